"""The policy's side of a drive: what it would do next, said before it is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.decision import Choice, Decision
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.policies.hierarchy.step_log import Step
from lerobot_llakey.rollout.actors import Agent

ROW = 0
"""A drive has one scene: the only row of its batches."""


class Pilot:
    """A hierarchical policy and the corrections of a person, for one scene at a time.

    Observations are unbatched ones of the environment. Everything but :attr:`corrections` is used from one thread.

    Args:
        agent: the policy with its processors.

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
        self.corrections = policy.loop.corrections
        self.known: Sequence[str] = tuple(policy.config.command.instructions)
        self._decision: Decision | None = None

    def reset(self) -> None:
        """Forget the last episode, with its corrections and its goal."""
        self._agent.reset()
        self._decision = None

    def propose(self, task: str, observation: Mapping[str, Any]) -> Choice:
        """What :meth:`act` will carry out, unless corrections or the goal change; nothing is done.

        Args:
            task: the scene's own goal.
            observation: the present one; the same one until :meth:`act`.
        """
        self._decision = self._policy.decide(self._agent.batch(task, observation), known=self._decision)
        return self._decision.choices[ROW]

    def act(self) -> tuple[np.ndarray, Step]:
        """Carry out what was proposed last: the action (9,) to send, and the policy's record."""
        assert self._decision is not None
        with torch.inference_mode():
            action: np.ndarray = self._agent.postprocessor(self._policy.act(self._decision))[ROW].cpu().numpy()
        self._decision = None
        return action, self._policy.log[ROW][-1]
