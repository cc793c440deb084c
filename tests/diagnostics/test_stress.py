"""Random legal actions, and that what goes wrong is seen."""

import numpy as np
import pytest

from lerobot_llakey.diagnostics.stress import Stress, stress, stress_episode
from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(make_task("move_block"))


def test_random_actions_are_taken_and_counted() -> None:
    found = stress(["move_block"], 50, num_workers=1)["move_block"]
    assert found.actions == found.outcomes.total() == 50
    assert found.stands and found.outcomes["moved"] > 5 and found.slowest > 0


def test_a_body_under_the_table_is_seen(simulation: Simulation, monkeypatch: pytest.MonkeyPatch) -> None:
    world = simulation.world

    def bury(*_: object) -> None:
        world.place("red_block", Pose(np.array((0.4, 0.1, -0.2))))
        simulation.clock.advance(0.01)

    monkeypatch.setattr(simulation, "act", bury)
    found = stress_episode(simulation, 3)
    assert found.sunk == [("red_block", 3)] and not found.stands


def test_a_state_that_is_not_finite_is_seen(simulation: Simulation, monkeypatch: pytest.MonkeyPatch) -> None:
    world = simulation.world

    def break_down(*_: object) -> None:
        world.data.qvel[0] = np.nan

    monkeypatch.setattr(simulation, "act", break_down)
    found = stress_episode(simulation, 3)
    assert found.not_finite == 1 and found.actions == 1 and not found.stands


def test_counts_add_up() -> None:
    total = Stress("move_block", 25, slowest=1.0)
    total.add(Stress("move_block", 25, not_finite=1, sunk=[("red_block", 0)], slowest=3.0))
    assert (total.actions, total.not_finite, total.slowest, len(total.sunk)) == (50, 1, 3.0, 1)
