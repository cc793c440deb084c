"""The command policy's next instruction, and when its model is asked."""

import math

import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy


@pytest.fixture
def policy(small_config, keysteps) -> LlakeyCommandPolicy:
    torch.manual_seed(0)
    return LlakeyCommandPolicy(small_config, dataset_meta=keysteps.meta)


def test_constrained_answers_are_known_instructions_even_untrained(policy, batch):
    assert policy.config.constrain
    assert set(policy.next_instructions(batch)) <= set(policy.config.instructions)


def test_the_model_is_asked_only_where_the_arm_stands(policy, batch):
    policy.eval()
    moves = (batch[schema.VELOCITY][:, 0] > 0).tolist()
    previous = batch[schema.PREVIOUS_INSTRUCTION]
    assert True in moves and False in moves
    policy.config.hold_above = None
    model = policy.answer(batch)
    policy.answered = policy.gated = 0
    policy.config.hold_above = 0.1
    answers = policy.answer(batch)
    for moved, last, answer, own in zip(moves, previous, answers, model, strict=True):
        assert answer.text == (last if moved else own.text)
        assert math.isnan(answer.likelihood) if moved else answer.likelihood == pytest.approx(own.likelihood, rel=1e-3)
    assert (policy.answered, policy.gated) == (moves.count(False), moves.count(True))
    batch[schema.VELOCITY] = torch.ones_like(batch[schema.VELOCITY])
    batch[schema.PREVIOUS_INSTRUCTION] = ["grasp the red block"] * len(moves)
    assert policy.next_instructions(batch) == ["grasp the red block"] * len(moves)


def test_a_task_without_words_is_not_acted_on(policy, batch):
    with pytest.raises(LlakeyError, match="words in task, got an empty text in batch row 0"):
        policy.answer(batch | {schema.TASK: [""] * 6})
