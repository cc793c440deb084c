import torch

from lerobot_llakey import schema
from lerobot_llakey.evaluation.abilities.measure import BY_SITUATION, measure
from lerobot_llakey.evaluation.abilities.report import markdown
from lerobot_llakey.evaluation.abilities.situation import (
    FINISHED,
    MOVING,
    SITUATIONS,
    START,
    UNFINISHED,
    situations,
)


def batch_with(speeds: list[float], previous: list[str]) -> dict:
    velocities = torch.zeros(len(speeds), len(schema.SIM_VELOCITY_NAMES))
    velocities[:, 2] = torch.tensor(speeds)
    expected = ["release the cup"] * len(speeds)
    return {schema.VELOCITY: velocities, schema.PREVIOUS_INSTRUCTION: previous, schema.INSTRUCTION: expected}


def test_what_stands_is_told_apart_by_what_comes_next() -> None:
    same, other = "release the cup", "grasp the cup"
    batch = batch_with([0.3, 0.0, 0.0, 0.3, 0.0, 0.3], [same, same, other, other, "", ""])
    assert situations(batch, range(7)) == [MOVING, UNFINISHED, FINISHED, MOVING, START, START]


def test_without_velocities_or_previous_instructions_nothing_is_known() -> None:
    for key in (schema.VELOCITY, schema.PREVIOUS_INSTRUCTION):
        batch = batch_with([0.3, 0.0], ["release the cup", ""])
        del batch[key]
        assert situations(batch, range(7)) == ["", ""]


class Stubborn:
    """Says the instruction last commanded."""

    def next_instructions(self, batch: dict) -> list[str]:
        return list(batch[schema.PREVIOUS_INSTRUCTION])


def test_every_frame_has_a_situation(dataset) -> None:
    measured = measure(Stubborn(), dict, dataset, batch_size=4)
    summary = measured.summary()
    found = summary[BY_SITUATION]
    abilities = ("sequential_prediction", "error_correction")
    assert sum(part["samples"] for part in found.values()) == sum(summary[name]["all"]["samples"] for name in abilities)
    assert {name: part["exact"] for name, part in found.items()} == {START: 0.0, MOVING: 1.0, FINISHED: 0.0}
    assert [name for name in SITUATIONS if f"| {name} " in markdown(measured)] == [START, MOVING, FINISHED]
