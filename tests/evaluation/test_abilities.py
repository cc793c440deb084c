from typing import Any

import pytest

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.evaluation.abilities import Score, abilities


class Echo:
    """Says the instruction last commanded: right in between keyframes, wrong at them."""

    def next_instructions(self, batch: dict[str, Any]) -> list[str]:
        return list(batch[schema.PREVIOUS_INSTRUCTION])


class Knowing:
    """Says the right instruction in its synonymous wording."""

    def next_instructions(self, batch: dict[str, Any]) -> list[str]:
        return [text.replace("grasp", "grab").replace("move to", "go to") for text in batch[schema.INSTRUCTION]]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "dataset", episodes=3, frames=6, cameras=("front",))


def test_wordings_of_the_same_instruction_count_as_right(dataset):
    result = abilities(Knowing(), dict, dataset, batch_size=4)
    for ability in ("sequential_prediction", "error_correction"):
        assert result[ability]["all"]["exact"] == 1.0
        assert result[ability]["all"]["confusions"] == []


def test_abilities_are_told_apart_at_keyframes(dataset):
    result = abilities(Echo(), dict, dataset, batch_size=4, group=lambda task: "pick up")
    expected = {
        ability: [index for index in range(len(dataset)) if bool(dataset[index][schema.IS_KEYFRAME]) == at_keyframe]
        for ability, at_keyframe in (("sequential_prediction", True), ("error_correction", False))
    }
    for ability, indices in expected.items():
        right = [dataset[i][schema.INSTRUCTION] == dataset[i][schema.PREVIOUS_INSTRUCTION] for i in indices]
        assert 0 < sum(right) < len(right)
        assert result[ability]["all"]["samples"] == len(right)
        assert result[ability]["all"]["exact"] == pytest.approx(sum(right) / len(right))
        assert result[ability]["pick up"] == result[ability]["all"]


def test_every_task_is_counted_apart(dataset):
    result = abilities(Knowing(), dict, dataset)
    tasks = {dataset[index]["task"] for index in range(len(dataset))}
    assert set(result["error_correction"]) == tasks | {"all"}
    assert (
        sum(result["error_correction"][task]["samples"] for task in tasks)
        == (result["error_correction"]["all"]["samples"])
    )


def test_fewer_samples_are_spread_over_the_dataset(dataset):
    result = abilities(Knowing(), dict, dataset, max_samples=6)
    assert sum(ability["all"]["samples"] for ability in result.values()) == 6


def test_verb_and_objects_are_counted_apart():
    score = Score()
    score.add("grasp the red block", "grasp the blue block")
    score.add("grasp the red block", "release the red block")
    score.add("move to the top of the red block", "move to the front of the red block")
    score.add("grasp the red block", "sing a song")
    summary = score.summary()
    assert (summary["samples"], summary["exact"], summary["verb"], summary["objects"]) == (4, 0.0, 0.5, 0.5)
    assert len(summary["confusions"]) == 4


def test_dataset_without_keyframes_is_named(tmp_path):
    dataset = fake_keysteps(tmp_path / "d", episodes=1, frames=2, cameras=("front",), without=(schema.IS_KEYFRAME,))
    with pytest.raises(ValueError, match=r"columns \['keyframe\.is_keyframe'\]"):
        abilities(Knowing(), dict, dataset)
