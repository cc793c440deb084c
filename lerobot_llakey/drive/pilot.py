"""The policy's side of a drive: what it would do next, said before it is done."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from lerobot_llakey.drive.remembering import Remembering
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.commanders.corrections import Corrections
from lerobot_llakey.policies.hierarchy.log import EpisodeLog
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.policies.hierarchy.record import Step
from lerobot_llakey.rollout.actors import Agent

ROW = 0
"""A drive has one scene: the only row of its batches."""


@dataclass(frozen=True)
class Proposal:
    """The instruction that the next step will carry out.

    Attributes:
        instruction: in its canonical wording.
        source: who said it, as in :class:`~lerobot_llakey.policies.hierarchy.record.Step`.
        likelihood: of the words to who said them, 0..1, where that is known.
        said: the commander's own words where others took their place, else "".
    """

    instruction: str
    source: str
    likelihood: float | None = None
    said: str = ""


class Pilot:
    """A hierarchical policy with a person's corrections around its commander, for one scene at a time.

    Observations are unbatched ones of the environment. Everything but :attr:`corrections` is used from one thread.

    Args:
        agent: the policy with its processors; the policy's commander is replaced.

    Attributes:
        corrections: where a person's words and goals go.
        known: the instructions that the command policy was trained to say, where it lists them.

    Raises:
        LlakeyError: if the agent's policy is no hierarchical one.
    """

    def __init__(self, agent: Agent) -> None:
        policy = agent.policy
        if not isinstance(policy, LlakeyPolicy):
            raise LlakeyError(
                f"Expected a checkpoint of type 'llakey', got one of type {policy.name!r}; join a command and an "
                "action policy with llakey compose."
            )
        self._agent, self._policy = agent, policy
        self._remembering = Remembering(policy.commander)
        self.corrections = Corrections(self._remembering, grammar=policy.config.spoken)
        policy.commander = self.corrections
        self.known: Sequence[str] = tuple(policy.config.command.instructions)
        self._batch: dict[str, Any] = {}

    def reset(self) -> None:
        """Forget the last episode, with its corrections and its goal."""
        self._agent.reset()

    def propose(self, task: str, observation: Mapping[str, Any]) -> Proposal:
        """What :meth:`act` will carry out, unless corrections or the goal change; nothing is done.

        Args:
            task: the scene's own goal.
            observation: the present one.
        """
        self._batch = self._agent.batch(task, observation)
        # The loop instructs a copy of itself, so that counting and drawing happen once: when the step is taken.
        loop = copy.copy(self._policy.loop)
        loop.supervisors, loop.log = copy.deepcopy(loop.supervisors), EpisodeLog()
        self._remembering.heard.clear()
        with torch.inference_mode():
            instruction = loop.instruct(self.corrections, self._batch)[ROW]
        supervisor, heard = loop.supervisors[ROW], self._remembering.heard
        if not heard:  # the person spoke, and nobody else was asked
            return Proposal(instruction, "person")
        if supervisor.took != "said":
            return Proposal(instruction, supervisor.took, said=heard[0].text)
        said = next(one for one in heard if supervisor.reading(one.text) == instruction)
        return Proposal(instruction, said.source, said.likelihood)

    def act(self) -> tuple[np.ndarray, Step]:
        """Take the step for the observation last proposed for: the action (9,) to send, and the policy's record."""
        action = self._agent.act_on(self._batch)
        return action, self._policy.log[ROW][-1]
