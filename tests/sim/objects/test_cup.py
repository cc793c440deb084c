"""A cup stands either way up, stays where it lies, is hollow, and lets go of the fingers that held it."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.objects.cup import CUP_HEIGHT, CUP_RADIUS, CUP_WALL, add_cup
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.world import World

SPOT = np.array((0.5, 0.0, 0.0))


class OneCup(Task):
    name = "one_cup"
    variations = 1

    def build(self, spec: mujoco.MjSpec) -> None:
        add_cup(spec, "cup", (0.9, 0.9, 0.9))

    def reset(self, world: World, variation: int) -> None:
        world.place("cup", Pose(SPOT))

    def success(self, world: World) -> bool:
        return False

    def plan(self, world: World) -> list[Waypoint]:
        return []


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(OneCup())


def stand(simulation: Simulation, height: float, rotation: Rotation) -> None:
    world = simulation.world
    simulation.reset(0)
    world.place("cup", Pose(SPOT + (0, 0, height), rotation.as_quat()))
    simulation.clock.advance(1.0)


def up(world: World) -> float:
    return float(world.pose("cup").rotation.as_matrix()[2, 2])


@pytest.mark.parametrize(("height", "turn", "upright"), [(0.001, 0.0, 1.0), (CUP_HEIGHT + 0.001, np.pi, -1.0)])
def test_it_stands_either_way_up(simulation: Simulation, height: float, turn: float, upright: float) -> None:
    world = simulation.world
    stand(simulation, height, Rotation.from_euler("x", turn))
    assert up(world) == pytest.approx(upright, abs=1e-3)
    assert np.linalg.norm(world.pose("cup").position[:2] - SPOT[:2]) < 0.002


@pytest.mark.parametrize("leaning", [0.25, 0.75])
def test_a_leaning_cup_stands_up_or_falls_over(simulation: Simulation, leaning: float) -> None:
    world = simulation.world
    stand(simulation, CUP_RADIUS * np.sin(leaning) + 0.001, Rotation.from_euler("y", leaning))
    assert up(world) > 0.99 if leaning < 0.4 else abs(up(world)) < 0.05


def test_a_lying_cup_that_is_pushed_stops_rolling(simulation: Simulation) -> None:
    world = simulation.world
    stand(simulation, CUP_RADIUS + 0.001, Rotation.from_euler("y", np.pi / 2))
    before = world.pose("cup").position
    address = int(world.model.joint(world.model.body("cup").jntadr[0]).dofadr[0])
    world.data.qvel[address + 1] = 0.15
    simulation.clock.advance(1.5)
    assert np.linalg.norm(world.pose("cup").position - before) < 0.12
    assert np.abs(world.data.qvel[address : address + 6]).max() < 0.01


@pytest.mark.parametrize("yaw", np.deg2rad((0.0, 7.0, 15.0, 22.0)))
def test_it_is_clamped_by_its_wall_and_let_go_where_it_was(simulation: Simulation, yaw: float) -> None:
    world = simulation.world
    stand(simulation, 0.001, Rotation.from_euler("z", yaw))
    before = world.pose("cup").position
    grasp = Pose(SPOT + (0, -CUP_RADIUS + CUP_WALL / 2, CUP_HEIGHT - 0.013), top_down())
    for pose, opened in ((grasp.shifted(z=0.1), True), (grasp, False)):
        simulation.motion.execute(pose, opened, True)
    assert world.holds("cup")
    simulation.motion.execute(grasp.shifted(z=0.08), False, True)
    assert world.pose("cup").position[2] > 0.07
    simulation.motion.execute(grasp.shifted(z=0.003), False, True)
    simulation.motion.execute(world.tool, True, True)
    assert not world.holds("cup") and up(world) > 0.999
    assert np.linalg.norm(world.pose("cup").position - before) < 0.008
