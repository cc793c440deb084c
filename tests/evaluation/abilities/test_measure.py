from typing import Any

import pytest

from lerobot_llakey import schema
from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured, measure
from lerobot_llakey.evaluation.abilities.samples import samples


class Echo:
    """Says the instruction last commanded: right in between keyframes, wrong at them."""

    def next_instructions(self, batch: dict[str, Any]) -> list[str]:
        return list(batch[schema.PREVIOUS_INSTRUCTION])


class Knowing:
    """Says the right instruction in its synonymous wording."""

    def next_instructions(self, batch: dict[str, Any]) -> list[str]:
        return [text.replace("grasp", "grab").replace("move to", "go to") for text in batch[schema.INSTRUCTION]]


def test_wordings_of_the_same_instruction_count_as_right(dataset):
    result = measure(Knowing(), dict, dataset, batch_size=4).summary()
    for ability in ABILITIES:
        assert result[ability]["all"]["exact"] == result[ability]["average"]["exact"] == 1.0
        assert result[ability]["all"]["confusions"] == []


def test_abilities_are_told_apart_at_keyframes(dataset):
    result = measure(Echo(), dict, dataset, batch_size=4).summary()
    expected = {
        ability: [index for index in samples(dataset) if bool(dataset[index][schema.IS_KEYFRAME]) == at_keyframe]
        for ability, at_keyframe in zip(ABILITIES, (True, False), strict=True)
    }
    for ability, indices in expected.items():
        right = [dataset[i][schema.INSTRUCTION] == dataset[i][schema.PREVIOUS_INSTRUCTION] for i in indices]
        assert result[ability]["all"]["samples"] == len(right)
        assert result[ability]["all"]["exact"] == pytest.approx(sum(right) / len(right))
        assert result[ability]["pick_up"] == result[ability]["all"]
    assert result["sequential_prediction"]["all"]["exact"] == 0 < result["error_correction"]["all"]["exact"] < 1


def test_fewer_samples_are_spread_over_the_dataset(dataset):
    result = measure(Knowing(), dict, dataset, max_samples=6).summary()
    assert sum(result[ability]["all"]["samples"] for ability in ABILITIES) == 6


def test_frames_after_an_event_are_counted_there_as_well():
    measured = Measured()
    ability = ABILITIES[0]
    measured.add(ability, "a", "drop", "grasp the cup", "grasp the cup")
    measured.add(ability, "b", "drop", "grasp the cup", "release the cup")
    measured.add(ability, "b", "", "grasp the cup", "grasp the cup")
    after = measured.summary()["after_events"]
    assert after[ability]["drop"]["samples"] == 2 and after[ability]["drop"]["exact"] == 0.5
    assert after[ABILITIES[1]] == {}
    assert measured.total(ability).samples == 3
