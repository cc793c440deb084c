"""The expert solves what it is given and recovers from what it finds."""

from lerobot_llakey.geometry import top_down
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.simulation import Simulation


def test_a_demonstration_ends_with_success(simulation: Simulation) -> None:
    simulation.reset(11)
    steps = list(demonstrate(simulation))
    assert steps[-1].success and not any(step.success for step in steps[:-1])
    assert list(demonstrate(simulation)) == []


def test_the_step_limit_holds(simulation: Simulation) -> None:
    simulation.reset(11)
    assert len(list(demonstrate(simulation, max_steps=2))) == 2


def test_it_replans_from_where_things_are(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(11)
    demonstration = demonstrate(simulation)
    next(demonstration), next(demonstration)
    lost = world.tool.shifted(x=-0.15, z=0.1)
    simulation.motion.execute(type(lost)(lost.position, top_down()), True, True)
    assert not world.held_bodies()
    assert list(demonstrate(simulation))[-1].success
