"""A hand that ends beside its marks."""

from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.perturbations.registry import EXECUTION_NOISE, make_perturbation
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


def test_an_imprecise_hand_ends_beside_its_marks_but_the_expert_gets_there() -> None:
    simulation = Simulation(make_task("move_block"))
    simulation.reset(3, 0, make_perturbation(EXECUTION_NOISE, 3, "move_block"))
    offsets = []
    for step in demonstrate(simulation):
        assert simulation.perturbation is not None
        if simulation.perturbation.time is not None:
            offsets.append(simulation.world.tool.distance(step.waypoint.pose)[0])
    assert step.success and 0.004 < max(offsets) < 0.03
