"""A seed alone determines a scene."""

import numpy as np
import pytest

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.perturbations.events import Event
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


def test_reset_forgets_what_came_before(drawer_world: World) -> None:
    drawer_world.reset(5)
    first = drawer_world.data.qpos.copy(), drawer_world.model.geom_rgba.copy(), drawer_world.task.description
    list(demonstrate(drawer_world))
    drawer_world.reset(6)
    drawer_world.reset(5)
    assert np.array_equal(first[0], drawer_world.data.qpos)
    assert np.array_equal(first[1], drawer_world.model.geom_rgba)
    assert first[2] == drawer_world.task.description


def test_two_worlds_do_not_share_their_scene(drawer_world: World) -> None:
    other = World(make_task("open_drawer"))
    drawer_world.reset(5)
    other.reset(6)
    assert not np.array_equal(other.model.body("cabinet").pos, drawer_world.model.body("cabinet").pos)


def test_variation_may_be_asked_for(drawer_world: World) -> None:
    for variation in range(3):
        drawer_world.reset(0, variation)
        assert drawer_world.task.variation == variation
    with pytest.raises(ValueError, match="Expected the variation of open_drawer"):
        drawer_world.reset(0, 3)


def test_state_follows_the_contract(drawer_world: World) -> None:
    drawer_world.reset(0)
    state = drawer_world.state()
    assert state.shape == (15,) and state.dtype == np.float32
    assert np.allclose(state[:3], drawer_world.tool.position)
    assert state[7] == pytest.approx(1.0, abs=0.02)


def test_observer_is_called_at_its_rate(drawer_world: World) -> None:
    drawer_world.reset(0)
    frames: list[float] = []
    drawer_world.observe(lambda: frames.append(drawer_world.data.time), 10)
    drawer_world.advance(1.0)
    drawer_world.observe(None)
    assert len(frames) == 10 and np.allclose(np.diff(frames), 0.1)


def test_holding_is_seen_by_contact(drawer_world: World) -> None:
    drawer_world.reset(0)
    assert drawer_world.held_bodies() == set()
    for step in demonstrate(drawer_world):
        if step.waypoint.instruction.startswith("grasp"):
            break
    assert drawer_world.holds(f"{drawer_world.task.drawer}_drawer")
    assert drawer_world.carried() == []  # a drawer slides on its rails, it is not carried


def test_the_events_of_two_tasks_do_not_strike_in_step(drawer_world: World) -> None:
    jar_world = World(make_task("close_jar"))

    def moments(world: World) -> list[int]:
        drawn = []
        for seed in range(4):
            world.reset(seed, disturbance="drop")
            assert isinstance(world.disturbance, Event)
            drawn.append(int(world.disturbance.rng.integers(2**31)))
        return drawn

    assert moments(drawer_world) == moments(drawer_world)
    assert len({*moments(drawer_world), *moments(jar_world)}) == 8
