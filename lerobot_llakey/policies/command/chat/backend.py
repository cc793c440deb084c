"""Asks a hosted model in place of the command policy's local one."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from torch import Tensor

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat.client import ChatClient, ChatCounts
from lerobot_llakey.policies.command.chat.messages import Message, draw_examples, question, solved, system_message
from lerobot_llakey.policies.command.chat.settings import check_address
from lerobot_llakey.policies.command.prompt import Prompt, answer_forms, answer_list

if TYPE_CHECKING:
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


class ChatBackend:
    """Replaces the local model of a command policy.

    Args:
        config: of the policy; ``instructions`` are the known answers.

    Raises:
        LlakeyError: if no model is named, the address holds a secret, ``guidance`` is "known" but no instructions are,
            or the ``openai`` package is not installed.
    """

    def __init__(self, config: LlakeyCommandConfig) -> None:
        check_address(config.base_url, config.model)
        self.settings = config.chat
        self._cameras, self._history = tuple(config.cameras), bool(config.history)
        self._guidance = _guidance(config)
        self._client = ChatClient(config.base_url, str(config.model), config.chat, config.max_new_tokens, config.rules)

    @property
    def counts(self) -> ChatCounts:
        """What happened to the requests so far."""
        return self._client.counts

    @cached_property
    def _examples(self) -> list[Message]:
        # Drawn at the first question: a saved policy loads without the examples' dataset.
        examples = draw_examples(self.settings, self._cameras, self._history)
        return solved(examples, self.settings.image_format)

    def answers(self, images: Tensor, prompts: Sequence[Prompt]) -> list[str]:
        """The model's answer to each row; see :meth:`ChatClient.ask_all` for empty answers and errors.

        Args:
            images: (B, V, 3, H, W) in 0..1.
            prompts: one a row.
        """
        conversations = [
            [
                system_message(prompt, self._guidance),
                *self._examples,
                question(prompt, row, self.settings.image_format),
            ]
            for prompt, row in zip(prompts, images, strict=True)
        ]
        return self._client.ask_all(conversations)


def _guidance(config: LlakeyCommandConfig) -> str:
    if config.chat.guidance == "none":
        return ""
    if config.chat.guidance == "forms":
        return answer_forms(config.rules)
    if not config.instructions:
        raise LlakeyError(
            "Expected known instructions for chat.guidance=known, got none; list them in --policy.instructions, take "
            "the command settings of a trained checkpoint, or use chat.guidance=forms."
        )
    return answer_list(config.instructions)
