"""A hand that ends beside its marks."""

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.perturbations.registry import IMPRECISE
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World


def test_an_imprecise_hand_ends_beside_its_marks_but_the_expert_gets_there() -> None:
    world = World(make_task("move_block"))
    world.reset(3, 0, IMPRECISE)
    offsets = []
    for step in demonstrate(world):
        assert world.disturbance is not None
        if world.disturbance.time is not None:
            offsets.append(world.tool.distance(step.waypoint.pose)[0])
    assert step.success and 0.004 < max(offsets) < 0.03
