"""The right bulb lights the lamp, whatever goes wrong on the way."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES, COLOURS
from lerobot_llakey.sim.perturbations.registry import make_perturbation
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.light_bulb_in import LightBulbIn
from lerobot_llakey.sim.world import World

STAGES = ["move", "grasp", "raise", "align", "place", "screw_in", "release"]


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(LightBulbIn())


def act(simulation: Simulation, steps: int) -> None:
    """Let the expert take some actions."""
    for _, step in zip(range(steps), demonstrate(simulation), strict=False):
        assert step.failure == ""


def templates(simulation: Simulation) -> list[str]:
    """Let the expert finish, and tell what it did."""
    steps = list(demonstrate(simulation))
    assert steps[-1].success and simulation.plan() == []
    return [parse(step.waypoint.instruction).template for step in steps]


def lit(world: World) -> bool:
    return world.joint("lamp_light") > 0.2


def screw_in_the_other(simulation: Simulation) -> None:
    """As the expert would, but with the other bulb."""
    world = simulation.world
    shift = world.pose("other_bulb").position - world.pose("bulb").position
    for index, waypoint in enumerate(simulation.plan()):
        pose = waypoint.pose.shifted(*shift[:2]) if index < 3 else waypoint.pose
        simulation.motion.execute(pose, waypoint.gripper_open, waypoint.ignore_collision)


@pytest.mark.parametrize(("seed", "variation"), [(0, 0), (1, 7), (2, 9), (3, 19)])
def test_expert_lights_the_lamp_in_seven_actions(simulation: Simulation, seed: int, variation: int) -> None:
    world = simulation.world
    simulation.reset(seed, variation)
    colour = COLOUR_NAMES[variation]
    assert not simulation.success() and not lit(world)
    assert colour in simulation.task.description
    assert np.allclose(world.model.geom("bulb_collar").rgba[:3], COLOURS[colour])
    planned = [waypoint.instruction for waypoint in simulation.plan()]
    assert planned[0] == f"move to the top of the {colour} light bulb"
    steps = list(demonstrate(simulation))
    assert steps[-1].success and simulation.plan() == [] and lit(world)
    assert [step.waypoint.instruction for step in steps] == planned
    assert [parse(text).template for text in planned] == STAGES


def test_scene_is_a_function_of_the_seed_and_leaves_room(simulation: Simulation) -> None:
    world = simulation.world
    for seed in range(20):
        simulation.reset(seed)
        places = np.array([world.pose(body).position[:2] for body in ("lamp", "holder", "other_holder")])
        assert (np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1) > 0.15).all()
        for bulb, holder in (("bulb", 1), ("other_bulb", 2)):
            assert np.linalg.norm(world.pose(bulb).position[:2] - places[holder]) < 0.004
        description = simulation.task.description
        simulation.reset(seed)
        again = np.array([world.pose(body).position[:2] for body in ("lamp", "holder", "other_holder")])
        assert np.array_equal(places, again) and description == simulation.task.description


def test_the_lamp_lights_up_once_screwed_and_success_needs_a_release(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(4)
    act(simulation, 5)
    assert not lit(world)
    act(simulation, 1)
    assert lit(world) and world.holds("bulb") and not simulation.success()
    assert [parse(waypoint.instruction).template for waypoint in simulation.plan()] == ["release"]


def test_expert_fetches_a_bulb_that_fell_on_its_side(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(5)
    act(simulation, 4)
    lamp = world.pose("lamp").position
    position = np.array((0.5, -0.25 if lamp[1] > 0 else 0.25, 0.06))
    world.place("bulb", Pose(position, Rotation.from_euler("y", 1.4).as_quat()))
    simulation.clock.advance(1.5)
    assert parse(simulation.plan()[0].instruction).template == "move"
    assert templates(simulation) == STAGES


def test_a_half_screwed_bulb_is_screwed_on(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(6)
    act(simulation, 5)
    screw = simulation.plan()[0]
    half = Pose(screw.pose.position, top_down(np.deg2rad(15)))
    simulation.motion.execute(half, False, True)
    simulation.motion.execute(world.tool, True, True)
    assert not simulation.success() and not lit(world)
    assert templates(simulation) == ["move", "grasp", "screw_in", "release"]


def test_a_bulb_that_leans_in_the_hand_is_set_upright(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(7)
    act(simulation, 2)
    lean = Rotation.from_rotvec(world.tool.rotation.apply((0.0, np.deg2rad(15), 0.0)))
    simulation.motion.execute(
        Pose(world.tool.shifted(z=0.06).position, (lean * world.tool.rotation).as_quat()), False, True
    )
    assert templates(simulation)[-3:] == ["place", "screw_in", "release"]


def test_the_wrong_bulb_in_the_hand_is_let_go(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(8)
    task = simulation.task
    assert isinstance(task, LightBulbIn)
    grasp = Pose(world.pose("other_bulb").position, top_down(np.deg2rad(55))).shifted(z=0.06)
    simulation.motion.execute(grasp.shifted(z=0.1), True, True)
    simulation.motion.execute(grasp, False, True)
    assert world.holds("other_bulb")
    assert task.plan(world)[0].instruction == f"release the {task.colours[1]} light bulb"
    assert templates(simulation) == ["release", *STAGES]


def test_the_wrong_bulb_lights_the_lamp_but_is_no_success_and_goes_back_to_its_holder(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(9)
    screw_in_the_other(simulation)
    assert lit(world) and not simulation.success()
    assert templates(simulation) == ["move", "grasp", "screw_out", "raise", "move", "release", *STAGES]
    assert np.linalg.norm((world.pose("other_bulb").position - world.pose("other_holder").position)[:2]) < 0.02


@pytest.mark.parametrize("kind", ["drop", "block", "shift", "empty_grasp"])
def test_expert_recovers(simulation: Simulation, kind: str) -> None:
    simulation.reset(10, None, make_perturbation(kind, 10, simulation.task.name))
    assert list(demonstrate(simulation))[-1].success
    assert simulation.perturbation is not None and simulation.perturbation.struck
