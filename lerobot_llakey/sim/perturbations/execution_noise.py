"""A hand that does not end where it was meant to."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.simulation import Simulation

_OFF_TARGET, _OFF_ANGLE = 0.02, np.deg2rad(12.0)
_OFF_SHARE = 0.5
"""Metres and radians by which an imprecise action is off at most, and the share of actions that are."""


class ExecutionNoise:
    """A hand that ends beside its mark in about every other action, by up to 2 cm and 12 degrees.

    Demonstrations under it show how to go on from where a learned policy will find itself.

    Args:
        rng: decides when and how far.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.struck = rng, False
        self.time: float | None = None

    def execute(self, simulation: Simulation, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Carry out one keyframe action, off its mark where that pose can be reached."""
        self.time = None
        if self.rng.random() < _OFF_SHARE:
            aside = _random_vector(self.rng) * self.rng.uniform(0, _OFF_TARGET)
            turn = Rotation.from_rotvec(_random_vector(self.rng) * self.rng.uniform(0, _OFF_ANGLE))
            beside = Pose(target.position + aside, (turn * target.rotation).as_quat())
            try:
                simulation.motion.execute(beside, gripper_open, ignore_collision)
            except PlanningError:
                pass
            else:
                self.struck, self.time = True, float(simulation.world.data.time)
                return
        simulation.motion.execute(target, gripper_open, ignore_collision)


def _random_vector(rng: np.random.Generator) -> np.ndarray:
    """(3,) of length 1, in any direction."""
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)
