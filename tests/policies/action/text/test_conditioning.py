"""The words that steer the action policy come from where the settings say."""

import numpy as np
import pytest

from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.action.text.conditioning import read_texts


def test_the_instruction_comes_before_the_oracle_and_the_task_never_stands_in() -> None:
    batch, _, _ = observation(rows=2)
    batch |= {schema.TASK: ["a", "b"], schema.ORACLE_INSTRUCTION: ["raise", "grasp"], schema.INSTRUCTION: ["c", "d"]}
    assert read_texts(batch, small_config(), 2) == [["c", "d"]]
    del batch[schema.INSTRUCTION]
    assert read_texts(batch, small_config(), 2) == [["raise", "grasp"]]
    del batch[schema.ORACLE_INSTRUCTION]
    with pytest.raises(ValueError, match="Expected 'instruction' in the batch"):
        read_texts(batch, small_config(), 2)


def test_the_task_alone_or_both_can_steer() -> None:
    batch, _, _ = observation(rows=1)
    batch |= {schema.TASK: ["close the red jar"], schema.INSTRUCTION: ["grasp the red lid"]}
    assert read_texts(batch, small_config(condition_on="task"), 1) == [["close the red jar"]]
    assert read_texts(batch, small_config(condition_on="both"), 1) == [["close the red jar"], ["grasp the red lid"]]


def test_in_training_the_last_text_alone_is_reworded() -> None:
    batch, _, _ = observation(rows=20)
    batch |= {schema.TASK: ["grasp the red lid"] * 20, schema.INSTRUCTION: ["grasp the red lid"] * 20}
    config = small_config(condition_on="both", paraphrase_probability=1.0)
    tasks, instructions = read_texts(batch, config, 20, np.random.default_rng(0))
    assert set(tasks) == {"grasp the red lid"}
    assert "grab the red lid" in instructions
    assert read_texts(batch, config, 20) == [tasks, tasks]


def test_an_empty_instruction_is_named_with_its_row() -> None:
    batch, _, _ = observation(rows=2)
    batch[schema.INSTRUCTION][1] = " "
    with pytest.raises(ValueError, match=r"words in instruction, got an empty text in batch row 1"):
        read_texts(batch, small_config(), 2)
