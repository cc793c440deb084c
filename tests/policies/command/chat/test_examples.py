import numpy as np
import pytest
import torch

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.command.chat.examples import draw_examples, spread
from lerobot_llakey.policies.command.chat.settings import ChatSettings

VIEWS = ("wrist", "front")


def _settings(dataset, count: int, seed: int = 0) -> ChatSettings:
    return ChatSettings(
        examples=count, examples_repo_id=dataset.repo_id, examples_root=str(dataset.root), examples_seed=seed
    )


def test_examples_are_samples_of_the_dataset_in_the_prompts_form(keysteps):
    examples = draw_examples(_settings(keysteps, 4), VIEWS, history=True)
    assert len({example.answer for example in examples}) == 4  # as many as there are
    samples = [keysteps[index] for index in range(len(keysteps))]
    for example in examples:
        keys = [schema.image_key(view) for view in VIEWS]
        matches = [
            sample
            for sample in samples
            if sample[schema.INSTRUCTION] == example.answer
            and torch.equal(torch.stack([sample[key] for key in keys]), example.images)
            and (sample[schema.TASK], sample[schema.PREVIOUS_INSTRUCTION])
            == (example.prompt.task, example.prompt.previous)
        ]
        assert matches and example.prompt.views == VIEWS


def test_the_seed_decides_which_and_history_is_left_out_where_it_is_off(keysteps):
    first, again, other = (draw_examples(_settings(keysteps, 3, seed), VIEWS, history=False) for seed in (0, 0, 1))
    assert [example.answer for example in first] == [example.answer for example in again]
    assert all(torch.equal(a.images, b.images) for a, b in zip(first, again, strict=True))
    assert [example.answer for example in first] != [example.answer for example in other]
    assert {example.prompt.previous for example in first} == {None}
    assert draw_examples(ChatSettings(), VIEWS, history=True) == []


def test_no_label_comes_twice_before_all_came_once():
    labels = ["a"] * 10 + ["b"] * 2 + ["c"]
    drawn = [labels[index] for index in spread(labels, 6, np.random.default_rng(0))]
    assert sorted(drawn[:3]) == ["a", "b", "c"] and sorted(drawn[3:5]) == ["a", "b"] and drawn[5] == "a"


def test_datasets_that_do_not_serve_are_named(keysteps, tmp_path):
    with pytest.raises(ValueError, match="at least 99 samples"):
        draw_examples(_settings(keysteps, 99), VIEWS, history=True)
    with pytest.raises(ValueError, match=r"add observation\.images\.elbow"):
        draw_examples(_settings(keysteps, 1), ("elbow",), history=True)
    bare = fake_keysteps(tmp_path / "bare", episodes=1, image_size=16, without=(schema.INSTRUCTION,))
    with pytest.raises(ValueError, match=r"with the column 'instruction'"):
        draw_examples(_settings(bare, 1), VIEWS, history=True)
