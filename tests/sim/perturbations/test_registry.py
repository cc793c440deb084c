"""Perturbations by name."""

import pytest

from lerobot_llakey.sim.perturbations.events import EVENTS, Event
from lerobot_llakey.sim.perturbations.execution_noise import ExecutionNoise
from lerobot_llakey.sim.perturbations.registry import DISTURBANCES, make_perturbation


def test_every_name_makes_a_perturbation_that_has_not_struck() -> None:
    made = {kind: make_perturbation(kind, 0, "open_drawer") for kind in DISTURBANCES}
    assert all(isinstance(made[kind], Event) for kind in EVENTS)
    assert isinstance(made["execution_noise"], ExecutionNoise)
    assert not any(one is None or one.struck or one.time is not None for one in made.values())
    assert make_perturbation("", 0, "open_drawer") is None


def test_an_unknown_disturbance_is_refused() -> None:
    with pytest.raises(ValueError, match="got 'earthquake'; pick one"):
        make_perturbation("earthquake", 0, "open_drawer")


def test_the_events_of_two_tasks_do_not_strike_in_step() -> None:
    def moments(task: str) -> list[int]:
        made = [make_perturbation("drop", seed, task) for seed in range(4)]
        return [int(event.rng.integers(2**31)) for event in made if isinstance(event, Event)]

    assert moments("open_drawer") == moments("open_drawer")
    assert len({*moments("open_drawer"), *moments("close_jar")}) == 8
