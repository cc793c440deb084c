"""The perturbations by name."""

from __future__ import annotations

import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.perturbations.events import EVENTS, Event
from lerobot_llakey.sim.perturbations.execution_noise import ExecutionNoise
from lerobot_llakey.sim.simulation import Perturbation

EXECUTION_NOISE = "execution_noise"
DISTURBANCES = (*EVENTS, EXECUTION_NOISE)
"""What an episode can be disturbed by."""


def make_perturbation(kind: str, seed: int, task: str) -> Perturbation | None:
    """The perturbation of an episode.

    Args:
        kind: out of DISTURBANCES; empty for none.
        seed: of the scene; with the task it decides when and how the perturbation strikes.
        task: name of the task.

    Raises:
        LlakeyError: if the kind is unknown.
    """
    check_disturbance(kind)
    if not kind:
        return None
    # The name as well: one seed stands for a scene of each task, and their events are not to strike in step.
    rng = np.random.default_rng((seed, 1, *task.encode()))
    return ExecutionNoise(rng) if kind == EXECUTION_NOISE else Event(kind, rng)


def check_disturbance(kind: str) -> None:
    """Refuse what is no disturbance; an empty text asks for none.

    Raises:
        LlakeyError: if the kind is unknown.
    """
    if kind and kind not in DISTURBANCES:
        raise LlakeyError(f"Expected a disturbance out of {', '.join(DISTURBANCES)}, got {kind!r}; pick one of these.")
