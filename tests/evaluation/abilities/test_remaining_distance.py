import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.evaluation.abilities.measure import BY_REMAINING_DISTANCE, Measured, measure
from lerobot_llakey.evaluation.abilities.remaining_distance import REMAINING_DISTANCES, remaining_distances
from lerobot_llakey.evaluation.abilities.report import markdown


def batch_with(metres: list[float]) -> dict:
    state = torch.zeros(len(metres), schema.HAND_DIM)
    action = torch.zeros(len(metres), schema.ACTION_DIM)
    action[:, 1] = torch.tensor(metres)
    action[:, 3:] = 5.0  # nothing but the place counts
    return {schema.STATE: state, schema.ACTION: action, schema.INSTRUCTION: ["release the cup"] * len(metres)}


@pytest.mark.parametrize(
    ("metres", "expected"), [(0.0, 0), (0.009, 0), (0.011, 1), (0.049, 1), (0.06, 2), (0.19, 2), (0.21, 3), (2.0, 3)]
)
def test_bands_by_distance(metres: float, expected: int) -> None:
    assert remaining_distances(batch_with([metres, 0.1]), range(8)) == [
        REMAINING_DISTANCES[expected],
        REMAINING_DISTANCES[2],
    ]


def test_without_poses_nothing_is_known() -> None:
    batch = batch_with([0.1, 0.2])
    del batch[schema.ACTION]
    assert remaining_distances(batch, range(8)) == ["", ""]


class Knowing:
    """Says the right instruction."""

    def next_instructions(self, batch: dict) -> list[str]:
        return list(batch[schema.INSTRUCTION])


def test_every_frame_in_between_has_a_band(dataset) -> None:
    measured = measure(Knowing(), dict, dataset, batch_size=4)
    summary = measured.summary()
    counted = sum(entry["samples"] for entry in summary[BY_REMAINING_DISTANCE].values())
    assert counted == summary["error_correction"]["all"]["samples"] > 0
    assert "still had to go" in markdown(measured)


def test_keyframes_are_not_counted() -> None:
    measured = Measured()
    measured.add("sequential_prediction", "a", "", "grasp the cup", "grasp the cup", REMAINING_DISTANCES[0])
    assert measured.summary()[BY_REMAINING_DISTANCE] == {}
    measured.add("error_correction", "a", "", "grasp the cup", "release the cup", REMAINING_DISTANCES[0])
    assert measured.summary()[BY_REMAINING_DISTANCE][REMAINING_DISTANCES[0]]["exact"] == 0.0
