"""The expert solves what it is given and recovers from what it finds."""

from lerobot_llakey.geometry import top_down
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.world import World


def test_a_demonstration_ends_with_success(drawer_world: World) -> None:
    drawer_world.reset(11)
    steps = list(demonstrate(drawer_world))
    assert steps[-1].success and not any(step.success for step in steps[:-1])
    assert list(demonstrate(drawer_world)) == []


def test_the_step_limit_holds(drawer_world: World) -> None:
    drawer_world.reset(11)
    assert len(list(demonstrate(drawer_world, max_steps=2))) == 2


def test_it_replans_from_where_things_are(drawer_world: World) -> None:
    drawer_world.reset(11)
    demonstration = demonstrate(drawer_world)
    next(demonstration), next(demonstration)
    lost = drawer_world.tool.shifted(x=-0.15, z=0.1)
    drawer_world.motion.execute(type(lost)(lost.position, top_down()), True, True)
    assert not drawer_world.held_bodies()
    assert list(demonstrate(drawer_world))[-1].success
