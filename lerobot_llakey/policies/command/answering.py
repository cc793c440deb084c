"""Asks the command policy's model for instructions, and counts the answers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.decoding.answer import Answer, count_unparsable
from lerobot_llakey.policies.command.decoding.constrained import decode_answers
from lerobot_llakey.policies.command.inputs import read_prompts, stack_cameras
from lerobot_llakey.policies.command.motion_gate import gated_instructions


class Answering:
    """The methods of the command policy that name the next basic action."""

    config: Any
    model: Any
    encoder: Any
    chat: Any
    training: bool
    eval: Any
    train: Any
    answered: int
    unparsable: int
    gated: int
    _trie: Any
    _autocast: Any

    def next_instructions(self, batch: dict[str, Any]) -> list[str]:
        """The next basic action of each row of a batch, decoded greedily; see :meth:`answer`."""
        return [answer.text for answer in self.answer(batch)]

    @torch.no_grad()
    def answer(self, batch: dict[str, Any]) -> list[Answer]:
        """The next basic action of each row of a batch and its likelihood; every answer is counted.

        A row with a moving arm (``hold_above``) keeps its previous instruction, and the model is not asked.

        Args:
            batch: as for :meth:`forward`, without the instruction; a missing previous instruction counts as none.
                ``observation.velocity`` if the robot measures it.

        Raises:
            LlakeyError: if an image or the task is missing, or the policy was trained to act.
        """
        if self.config.target != "instruction":
            raise LlakeyError(
                "Expected a command policy that names instructions, got one with target=action, which acts by itself; "
                "give a checkpoint with target=instruction."
            )
        kept = gated_instructions(batch, self.config.hold_above, self.config.joints)
        asked = [row for row, text in enumerate(kept) if text is None]
        answers = self._answers(batch, asked)
        self.answered += len(answers)
        self.unparsable += count_unparsable(answers, self.config.rules)
        self.gated += len(kept) - len(asked)
        given = iter(answers)
        return [next(given) if text is None else Answer(text, math.nan) for text in kept]

    def _answers(self, batch: dict[str, Any], rows: Sequence[int]) -> list[Answer]:
        """The model's answers to some rows, instructions or actions."""
        if not rows:
            return []
        was_training = self.training
        self.eval()
        images, prompts = stack_cameras(batch, self.config.image_keys), read_prompts(batch, self.config)
        images, prompts = images[list(rows)], [prompts[row] for row in rows]
        if self.chat is not None:
            answers = [Answer(text, math.nan) for text in self.chat.answers(images, prompts)]
        else:
            trie = self._trie if self.config.constrain else None
            inputs = self.encoder.prompts(images, prompts)
            with self._autocast(images.device):
                answers = decode_answers(self.model, self.encoder, inputs, trie, self.config.max_new_tokens)
        self.train(was_training)
        return answers
