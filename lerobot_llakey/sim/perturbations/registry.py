"""What may come between the asking for an action and its carrying out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.perturbations.events import EVENTS, Event
from lerobot_llakey.sim.perturbations.execution_noise import Imprecision

if TYPE_CHECKING:
    from lerobot_llakey.sim.world import World

IMPRECISE = "imprecise"
DISTURBANCES = (*EVENTS, IMPRECISE)
"""What an episode can be disturbed by."""


class Disturbance(Protocol):
    """What comes between the asking for an action and its carrying out.

    Attributes:
        struck: whether it has struck in this episode.
        time: simulated seconds at which it struck during the last action, None where it did not.
    """

    struck: bool
    time: float | None

    def execute(self, world: World, target: Pose, gripper_open: bool, ignore_collision: bool) -> None:
        """Carry out one keyframe action, disturbed or not.

        Raises:
            PlanningError: as :meth:`lerobot_llakey.sim.motion.Motion.execute` does.
        """


def make_disturbance(kind: str, rng: np.random.Generator) -> Disturbance:
    """The disturbance of an episode by name.

    Args:
        kind: out of DISTURBANCES.
        rng: decides when and how it strikes.

    Raises:
        LlakeyError: if the kind is unknown.
    """
    check_disturbance(kind)
    return Imprecision(rng) if kind == IMPRECISE else Event(kind, rng)


def check_disturbance(kind: str) -> None:
    """Refuse what is no disturbance; an empty text asks for none.

    Raises:
        LlakeyError: if the kind is unknown.
    """
    if kind and kind not in DISTURBANCES:
        raise LlakeyError(f"Expected a disturbance out of {', '.join(DISTURBANCES)}, got {kind!r}; pick one of these.")
