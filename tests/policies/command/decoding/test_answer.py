import pytest
import torch

from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.decoding.answer import Answer, answer_metrics, count_unparsable

COUNTED = torch.tensor([[True, True, False], [True, True, True]])
RIGHT = torch.tensor([[True, True, False], [True, False, True]])


def test_only_basic_actions_are_parsable():
    texts = ["grasp the red block", "sing a song", "", "grab the red block"]
    assert count_unparsable([Answer(text, 1.0) for text in texts], BASIC_GRAMMAR) == 2


def test_padding_counts_for_nothing_and_one_wrong_token_makes_an_answer_wrong():
    assert answer_metrics(RIGHT, COUNTED, ["a", "b"]) == pytest.approx(
        {"token_accuracy": 0.8, "instruction_accuracy": 0.5}
    )


def test_changed_instructions_count_apart():
    assert answer_metrics(RIGHT, COUNTED, ["a", "b"], ["", "b"])["changed_instruction_accuracy"] == 1.0
    assert answer_metrics(RIGHT, COUNTED, ["a", "b"], ["a", "a"])["changed_instruction_accuracy"] == 0.0
    assert "changed_instruction_accuracy" not in answer_metrics(RIGHT, COUNTED, ["a", "b"], ["a", "b"])


def test_several_processes_all_have_the_same_metrics(monkeypatch):
    monkeypatch.setattr("torch.distributed.is_initialized", lambda: True)
    for processes, expected in ((1, True), (2, False)):
        monkeypatch.setattr("torch.distributed.get_world_size", lambda count=processes: count)
        assert ("changed_instruction_accuracy" in answer_metrics(RIGHT, COUNTED, ["a", "b"], ["", "b"])) == expected
