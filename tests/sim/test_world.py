"""The state of a scene: what tasks ask of it, and what of its model differs from the pristine one."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.simulation import Simulation


def test_state_follows_the_contract(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    state = world.state()
    assert state.shape == (15,) and state.dtype == np.float32
    assert np.allclose(state[:3], world.tool.position)
    assert state[7] == pytest.approx(1.0, abs=0.02)


def test_what_the_hand_holds_is_seen_by_contact(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    assert world.held_bodies() == set()
    for step in demonstrate(simulation):
        if step.waypoint.instruction.startswith("grasp"):
            break
    assert world.holds(f"{simulation.task.drawer}_drawer")  # type: ignore[attr-defined]
    assert world.carried() == []  # a drawer slides on its rails, it is not carried


def test_whatever_differs_from_the_pristine_model_is_found_and_brought_back(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    before = world.varied()
    assert {"geom_rgba", "light_pos", "body_pos"} <= set(before)
    world.model.geom_friction[3] += 0.1  # nothing that any task changes
    assert set(world.varied()) == {*before, "geom_friction"}
    world.vary(before)
    assert set(world.varied()) == set(before)
    assert all(np.array_equal(getattr(world.model, name), array) for name, array in before.items())
    world.reset(0)
    assert world.varied() == {}
