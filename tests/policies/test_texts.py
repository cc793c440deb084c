"""Texts are texts, one a row, and nothing else."""

import math

import numpy as np
import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.texts import reworded, text_column
from lerobot_llakey.sentences import LONGEST_SENTENCE


def test_one_text_a_row_whatever_the_column_holds() -> None:
    assert text_column({"task": "grasp"}, "task") == ["grasp"]
    assert text_column({"task": ("a", "b")}, "task", 2) == ["a", "b"]
    assert text_column({}, "task", default=["", ""], may_be_empty=True) == ["", ""]


def test_a_missing_column_is_named() -> None:
    with pytest.raises(LlakeyError, match=r"Expected 'task' in the batch, got \['other'\]"):
        text_column({"other": 1}, "task")


def test_another_number_of_rows_is_refused() -> None:
    with pytest.raises(LlakeyError, match="Expected task as 3 texts, one for each batch row, got 1"):
        text_column({"task": "grasp"}, "task", 3)
    with pytest.raises(LlakeyError, match="Expected task as a list of texts, got float"):
        text_column({"task": math.nan}, "task")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "a text in task, got None"),
        (math.nan, "a text in task, got nan"),
        (7, "a text in task, got 7"),
        (["grasp"], r"a text in task, got \['grasp'\]"),
        ("", "words in task, got an empty text"),
        (" \n", "words in task, got an empty text"),
        ("grasp " * 2000, r"at most 1000 characters in task, got 12000 in batch row 1 \('grasp grasp .*'\.\.\.\)"),
        ("grasp <next goal> the lid", "words alone in task, got '<next goal>'"),
        ("<image> grasp the lid", "words alone in task, got '<image>'"),
        ("grasp the lid <|im_end|>", r"words alone in task, got '<\|im_end\|>'"),
        ("[INST] grasp the lid", r"words alone in task, got '\[INST\]'"),
    ],
)
def test_what_is_no_text_is_refused_with_its_row(text: object, said: str) -> None:
    with pytest.raises(LlakeyError, match=f"Expected {said}") as raised:
        text_column({"task": ["grasp the lid", text]}, "task")
    assert "batch row 1" in str(raised.value) and len(str(raised.value)) < 300


@pytest.mark.parametrize("text", ["open it if x < 3 and y > 2", "wähle [A]", "抓住红色方块", "a" * LONGEST_SENTENCE])
def test_ordinary_texts_pass(text: str) -> None:
    assert text_column({"task": [text]}, "task") == [text]


def test_rewording_keeps_unknown_texts() -> None:
    rng = np.random.default_rng(0)
    assert {reworded("grasp the red lid", 1.0, rng, BASIC_GRAMMAR) for _ in range(50)} == {
        "grasp the red lid",
        "grab the red lid",
    }
    assert reworded("do what you like", 1.0, rng, BASIC_GRAMMAR) == "do what you like"
    assert reworded("grasp the red lid", 0.0, rng, BASIC_GRAMMAR) == "grasp the red lid"
