"""The drawers open, each on its own."""

import numpy as np
import pytest

from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.tasks.open_drawer import DRAWERS
from lerobot_llakey.sim.world import World


@pytest.mark.parametrize("variation", range(3))
@pytest.mark.parametrize("seed", range(2))
def test_expert_opens_the_right_drawer(drawer_world: World, variation: int, seed: int) -> None:
    drawer_world.reset(seed, variation)
    assert not drawer_world.task.success(drawer_world)
    assert DRAWERS[variation] in drawer_world.task.description
    steps = list(demonstrate(drawer_world))
    assert steps[-1].success and len(steps) == 3
    assert [parse(step.waypoint.instruction).template for step in steps] == ["move", "grasp", "pull_open"]
    others = [drawer_world.joint(f"{name}_drawer") for name in DRAWERS if name != DRAWERS[variation]]
    assert np.abs(others).max() < 0.02


def test_a_wrong_drawer_is_no_success(drawer_world: World) -> None:
    drawer_world.reset(0, 2)
    drawer_world.set_joint("bottom_drawer", 0.18)
    assert not drawer_world.task.success(drawer_world)
    drawer_world.set_joint("top_drawer", 0.16)
    assert drawer_world.task.success(drawer_world)
