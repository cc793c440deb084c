"""Bulbs go into their box, screwed ones by way of the thread."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import parse
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.perturbations.registry import make_perturbation
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED, PutBulb

COLOURS = ("red", "yellow", "blue", "green", "white")
STAGES = {
    SCREWED: ["move", "grasp", "screw_out", "raise", "move", "release"],
    LOOSE: ["move", "grasp", "raise", "move", "release"],
}
RED_PURPLE, BLUE_PURPLE, WHITE_ORANGE = 0, 4, 9


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(PutBulb())


def task_of(simulation: Simulation) -> PutBulb:
    assert isinstance(simulation.task, PutBulb)
    return simulation.task


def act(simulation: Simulation, steps: int) -> None:
    """Let the expert take some actions."""
    for _, step in zip(range(steps), demonstrate(simulation), strict=False):
        assert step.failure == ""


def templates(simulation: Simulation) -> list[str]:
    """Let the expert finish, and tell what it did."""
    steps = list(demonstrate(simulation))
    assert steps[-1].success and simulation.plan() == []
    return [parse(step.waypoint.instruction).template for step in steps]


def take(simulation: Simulation, bulb: str, yaw: float) -> None:
    world = simulation.world
    grasp = Pose(world.pose(bulb).position, top_down(yaw)).shifted(z=0.06)
    simulation.motion.execute(grasp.shifted(z=0.1), True, True)
    simulation.motion.execute(grasp, False, True)


@pytest.mark.parametrize("variation", range(10))
def test_expert_puts_each_bulb_in_each_box(simulation: Simulation, variation: int) -> None:
    world = simulation.world
    simulation.reset(variation, variation)
    colour, box = COLOURS[variation // 2], ("purple", "orange")[variation % 2]
    assert simulation.task.description == f"put the {colour} light bulb in the {box} box"
    assert simulation.task.sequence == (SCREWED if colour in ("red", "yellow") else LOOSE)
    assert not simulation.success()
    others = {other: world.pose(f"{other}_bulb") for other in COLOURS if other != colour}
    planned = [parse(waypoint.instruction).template for waypoint in simulation.plan()]
    assert templates(simulation) == planned == STAGES[simulation.task.sequence]
    for other, before in others.items():
        assert np.linalg.norm(world.pose(f"{other}_bulb").position - before.position) < 0.005


def test_screwed_bulbs_stand_higher_and_nothing_overlaps(simulation: Simulation) -> None:
    world = simulation.world
    for seed in range(10):
        simulation.reset(seed)
        poses = {colour: world.pose(f"{colour}_bulb") for colour in COLOURS}
        heights = {colour: pose.position[2] for colour, pose in poses.items()}
        assert all((heights[colour] > 0.015) == (colour in ("red", "yellow")) for colour in COLOURS)
        assert all(pose.rotation.as_matrix()[2, 2] > 0.99 for pose in poses.values())
        places = np.array([pose.position[:2] for pose in poses.values()])
        gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(5, 1)]
        assert gaps.min() > 0.1
        boxes = np.array([world.pose(f"{box}_box").position[:2] for box in ("purple", "orange")])
        assert np.abs(boxes[0] - boxes[1]).max() > 0.139
        assert np.abs(places[:, None] - boxes[None]).max(axis=2).min() > 0.09


def test_a_screwed_bulb_cannot_be_pulled_out(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0, RED_PURPLE)
    act(simulation, 2)
    assert world.holds("red_bulb")
    height = world.pose("red_bulb").position[2]
    simulation.motion.execute(world.tool.shifted(z=0.05), False, True)
    assert world.pose("red_bulb").position[2] - height < 0.003
    assert templates(simulation)[-3:] == ["raise", "move", "release"]


def test_a_bulb_unscrewed_already_is_just_taken(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(1, RED_PURPLE)
    act(simulation, 3)
    simulation.motion.execute(world.tool, True, True)
    assert world.pose("red_bulb").position[2] > 0.02
    assert templates(simulation) == STAGES[LOOSE]


def test_a_half_unscrewed_bulb_is_screwed_out(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(2, RED_PURPLE)
    act(simulation, 2)
    out = simulation.plan()[0].pose
    simulation.motion.execute(Pose(out.position, top_down(0.0)), False, True)
    simulation.motion.execute(world.tool, True, True)
    assert templates(simulation) == STAGES[SCREWED]


def test_only_the_asked_bulb_inside_the_asked_box_counts(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(3, BLUE_PURPLE)
    purple, orange = (world.pose(f"{box}_box").position for box in ("purple", "orange"))
    home = world.pose("blue_bulb")
    for bulb, position, done in (
        ("green", purple, False),
        ("blue", orange, False),
        ("blue", purple + (0.02, 0.02, 0.0), True),
        ("blue", purple + (0.0, 0.1, 0.0), False),
    ):
        world.place("blue_bulb", home)
        world.place(f"{bulb}_bulb", Pose(position + (0, 0, 0.006)))
        world.place("green_bulb", Pose(np.array((0.3, 0.0, 0.0)))) if bulb == "blue" else None
        simulation.clock.advance(0.3)
        assert simulation.success() == done, (bulb, position)


def test_a_bulb_above_its_box_in_the_hand_is_no_success(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(4, WHITE_ORANGE)
    act(simulation, 4)
    assert world.holds("white_bulb") and not simulation.success()
    assert [parse(waypoint.instruction).template for waypoint in simulation.plan()] == ["release"]


def test_expert_takes_a_bulb_out_of_the_wrong_box(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(5, BLUE_PURPLE)
    position = world.pose("orange_box").position + (0.03, 0.03, 0.02)
    world.place("blue_bulb", Pose(position, Rotation.from_euler("y", 0.6).as_quat()))
    simulation.clock.advance(1.0)
    assert templates(simulation) == STAGES[LOOSE]


def test_the_wrong_bulb_is_let_go(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(6, BLUE_PURPLE)
    take(simulation, "green_bulb", np.deg2rad(55))
    assert world.holds("green_bulb")
    assert simulation.plan()[0].instruction == "release the green light bulb"
    assert templates(simulation) == ["release", *STAGES[LOOSE]]


@pytest.mark.parametrize(
    ("kind", "variation"),
    [("drop", WHITE_ORANGE), ("block", RED_PURPLE), ("shift", WHITE_ORANGE), ("empty_grasp", RED_PURPLE)],
)
def test_expert_recovers(simulation: Simulation, kind: str, variation: int) -> None:
    simulation.reset(7, variation, make_perturbation(kind, 7, simulation.task.name))
    assert list(demonstrate(simulation))[-1].success
    assert simulation.perturbation is not None and simulation.perturbation.struck


def test_a_bulb_lifted_out_of_its_socket_is_not_caught_by_the_thread(simulation: Simulation) -> None:
    """Here the bulb turns a little as it leaves the socket."""
    world = simulation.world
    simulation.reset(52, 2)
    act(simulation, 4)
    assert world.holds("yellow_bulb") and world.pose("yellow_bulb").position[2] > 0.1


def test_the_way_to_the_box_leads_above_the_screwed_bulbs(simulation: Simulation) -> None:
    simulation.reset(93, 3)
    assert templates(simulation) == STAGES[SCREWED]
