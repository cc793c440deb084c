"""Doing again what was done in an earlier run of the same scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.rollout.actors import Actor, Decision
from lerobot_llakey.sim.env import LlakeySimEnv


class Replay:
    """Repeats the first steps of an episode, then hands over.

    Args:
        actions: (9,) each, as an earlier run recorded them.
        instructions: the basic instruction behind each.
        successor: acts from then on; None where the actions are the whole episode.
    """

    def __init__(
        self, actions: Sequence[Sequence[float]], instructions: Sequence[str], successor: Actor | None = None
    ) -> None:
        self._steps = list(zip(actions, instructions, strict=True))
        self._successor = successor
        self._step = 0

    def reset(self, seed: int | None = None) -> None:
        """Begin anew."""
        self._step = 0
        if self._successor is not None:
            self._successor.reset(seed)

    def act(self, env: LlakeySimEnv, observation: Mapping[str, Any]) -> Decision | None:
        """The recorded action (9,) and its instruction, or the successor's.

        Raises:
            LlakeyError: if the episode goes on although its record has ended.
        """
        if self._step < len(self._steps):
            action, instruction = self._steps[self._step]
            self._step += 1
            return np.array(action, dtype=np.float32), instruction
        if self._successor is None:
            raise LlakeyError(
                f"Expected the episode of {env.task} to end after its {len(self._steps)} recorded actions, but it goes "
                "on; replay it with the simulator that recorded it."
            )
        return self._successor.act(env, observation)
