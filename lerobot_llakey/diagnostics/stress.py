"""Whether the simulator stands whatever a policy asks for: random legal actions, many of them near the things."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.diagnostics.simulations import simulation_of
from lerobot_llakey.geometry import Pose
from lerobot_llakey.parallel import run_jobs
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.simulation import Simulation

_SUNK = -0.03
"""Metres below the table's top at which a body's centre has gone through it."""
_TABLE = ((-0.28, 0.98), (-0.68, 0.68))
"""Metres: the table's x and y, without its rim."""
_NEAR_SHARE = 0.6
"""Share of actions that are the expert's, moved and turned at random, so that things are met, grasped and torn at."""
_NEAR, _TURN = 0.06, 0.8


@dataclass
class Stress:
    """What some episodes of random actions came to.

    Attributes:
        task: its name.
        actions: number of actions.
        outcomes: number of actions by what happened: "moved", or why the arm did not.
        not_finite: episodes whose state became NaN or infinite, or in which MuJoCo found its physics wrong (it then
            starts anew from a reset state, without an error).
        sunk: names of bodies that went through the table, with the seed.
        slowest: seconds of the slowest episode.
    """

    task: str
    actions: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    not_finite: int = 0
    sunk: list[tuple[str, int]] = field(default_factory=list)
    slowest: float = 0.0

    @property
    def stands(self) -> bool:
        """Whether nothing went wrong."""
        return not self.not_finite and not self.sunk

    def add(self, other: Stress) -> None:
        """Count other episodes of the same task in."""
        self.actions += other.actions
        self.outcomes += other.outcomes
        self.not_finite += other.not_finite
        self.sunk += other.sunk
        self.slowest = max(self.slowest, other.slowest)


def stress_episode(simulation: Simulation, seed: int) -> Stress:
    """Take an episode of random legal actions in the scene of a seed."""
    world = simulation.world
    simulation.reset(seed)
    rng = np.random.default_rng((seed, 2))
    bodies = [body for body in _free_bodies(world.model) if world.pose(body).position[2] > _SUNK]
    found, start = Stress(simulation.task.name), time.perf_counter()
    for _ in range(MAX_STEPS):
        pose, gripper_open, ignore_collision = _action(simulation, rng)
        try:
            simulation.act(pose, gripper_open, ignore_collision)
            found.outcomes["moved"] += 1
        except PlanningError as error:
            found.outcomes[error.reason] += 1
        found.actions += 1
        if simulation.clock.warnings() or not (
            np.isfinite(world.data.qpos).all() and np.isfinite(world.data.qvel).all()
        ):
            found.not_finite += 1
            break
    found.sunk = [(body, seed) for body in bodies if _is_sunk(world.pose(body).position)]
    found.slowest = time.perf_counter() - start
    return found


def _action(simulation: Simulation, rng: np.random.Generator) -> tuple[Pose, bool, bool]:
    flags = bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    waypoints = simulation.plan()
    if waypoints and rng.random() < _NEAR_SHARE:
        pose = waypoints[int(rng.integers(len(waypoints)))].pose
        turn = Rotation.from_rotvec(rng.normal(size=3) * _TURN * rng.random())
        beside = pose.position + rng.uniform(-_NEAR, _NEAR, 3)
        return Pose(beside, (turn * pose.rotation).as_quat()), *flags
    low, high = np.transpose(schema.WORKSPACE)
    return Pose(rng.uniform(low, high), Rotation.random(random_state=rng).as_quat()), *flags


def _free_bodies(model: mujoco.MjModel) -> list[str]:
    free = model.jnt_type == mujoco.mjtJoint.mjJNT_FREE
    return [model.body(body).name for body in model.jnt_bodyid[free]]


def _is_sunk(position: np.ndarray) -> bool:
    inside = all(low < value < high for value, (low, high) in zip(position[:2], _TABLE, strict=True))
    return bool(inside and position[2] < _SUNK)


def _run(task: str, seeds: Sequence[int]) -> Stress:
    total = Stress(task)
    for seed in seeds:
        total.add(stress_episode(simulation_of(task), seed))
    return total


def stress(tasks: Sequence[str], num_actions: int, split: str = "val", num_workers: int = 0) -> dict[str, Stress]:
    """Take random legal actions in every task.

    Args:
        tasks: their names.
        num_actions: at least so many over all tasks, in whole episodes.
        split: of the scene seeds.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.

    Returns:
        What it came to, by task.

    Raises:
        LlakeyError: if the split is unknown.
    """
    episodes = -(-num_actions // (MAX_STEPS * len(tasks)))
    jobs = [(task, [schema.scene_seed(split, index)]) for index in range(episodes) for task in tasks]
    totals = {task: Stress(task) for task in tasks}
    with tqdm(total=len(jobs) * MAX_STEPS, unit="action", desc="stress") as bar:
        for found in run_jobs(_run, jobs, num_workers):
            totals[found.task].add(found)
            bar.update(MAX_STEPS)
    return totals
