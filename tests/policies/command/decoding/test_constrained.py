"""Both ways of decoding give the same answers, with likelihoods that are those of the whole model."""

import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.decoding.constrained import decode_answers, decode_by_branches, decode_by_steps
from lerobot_llakey.policies.command.decoding.trie import Trie
from lerobot_llakey.policies.command.inputs import read_prompts, stack_cameras
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy


@pytest.fixture
def policy(small_config, keysteps) -> LlakeyCommandPolicy:
    torch.manual_seed(3)
    policy = LlakeyCommandPolicy(small_config, dataset_meta=keysteps.meta).eval()
    for parameter in policy.model.lm_head.parameters():  # a fresh model is nearly indifferent
        parameter.data *= 8
    return policy


@pytest.fixture
def inputs(policy, batch) -> dict:
    tasks = [f"pick up {'the very ' * index}red block" for index in range(6)]
    prompts = read_prompts(batch | {schema.TASK: tasks}, policy.config)
    return policy.encoder.prompts(stack_cameras(batch, policy.config.image_keys), prompts)


def answers_by_scores(policy, inputs, texts) -> torch.Tensor:
    """Likelihood (B, N) of each text under the trie of all texts, from one forward pass a text."""
    trie = Trie(policy.encoder.answer(text) for text in texts)
    columns = []
    for text in texts:
        ids = policy.encoder.answer(text)
        count = len(inputs["input_ids"])
        whole = torch.cat((inputs["input_ids"], torch.tensor([ids] * count)), dim=1)
        mask = torch.cat((inputs["attention_mask"], torch.ones(count, len(ids), dtype=torch.long)), dim=1)
        scores = policy.model(input_ids=whole, attention_mask=mask, pixel_values=inputs["pixel_values"]).logits
        total = torch.zeros(count)
        for place, token in enumerate(ids):
            allowed = trie.next_tokens(ids[:place])
            told = torch.log_softmax(scores[:, place - len(ids) - 1, allowed], dim=1)
            total += told[:, allowed.index(token)]
        columns.append(total.exp())
    return torch.stack(columns, dim=1)


@torch.no_grad()
def test_greedy_answers_and_likelihoods_are_those_of_the_whole_model(policy, inputs):
    texts = policy.config.instructions
    expected = answers_by_scores(policy, inputs, texts)
    torch.testing.assert_close(expected.sum(dim=1), torch.ones(6))
    answers = decode_answers(policy.model, policy.encoder, inputs, policy._trie, 48)
    for answer, row in zip(answers, expected, strict=True):
        assert answer.likelihood == pytest.approx(float(row[texts.index(answer.text)]), rel=1e-3)
    assert len({answer.text for answer in answers}) > 1 or len({round(a.likelihood, 3) for a in answers}) > 1


@torch.no_grad()
@pytest.mark.parametrize("known", [True, False])
def test_both_ways_of_decoding_agree(policy, inputs, known):
    trie = policy._trie if known else None
    ids = policy.encoder.stop_id, policy.encoder.pad_id
    fast = decode_by_branches(policy.model, inputs, trie, *ids, 9)
    slow = decode_by_steps(policy.model, inputs, trie, *ids, 9)
    for (fast_ids, fast_log), (slow_ids, slow_log) in zip(fast, slow, strict=True):
        assert policy.encoder.decode(fast_ids) == policy.encoder.decode(slow_ids)
        assert fast_log == pytest.approx(slow_log, abs=1e-3)


@torch.no_grad()
def test_images_are_looked_at_once_and_only_branches_are_asked_for(policy, inputs):
    seen, passes = [], []
    hooks = [
        policy.model.model.vision_tower.register_forward_hook(lambda *_: seen.append(1)),
        policy.model.model.language_model.register_forward_hook(lambda *_: passes.append(1)),
    ]
    trie = Trie(policy.encoder.answer(text) for text in ("grasp the red block", "grasp the blue block"))
    answers = decode_answers(policy.model, policy.encoder, inputs, trie, 48)
    assert (len(seen), len(passes)) == (1, 2)
    assert {answer.text for answer in answers} <= {"grasp the red block", "grasp the blue block"}
    for hook in hooks:
        hook.remove()
