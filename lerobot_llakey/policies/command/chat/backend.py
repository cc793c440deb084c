"""The command policy's questions put to a hosted model, a bounded number at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from torch import Tensor

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat.client import ChatClient
from lerobot_llakey.policies.command.chat.counts import ChatCounts
from lerobot_llakey.policies.command.chat.examples import draw_examples
from lerobot_llakey.policies.command.chat.messages import Message, question, solved, system_message
from lerobot_llakey.policies.command.chat.settings import check_address
from lerobot_llakey.policies.command.prompt import Prompt, answer_forms, answer_list

if TYPE_CHECKING:
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


class ChatBackend:
    """Stands in for the local model of a command policy.

    Args:
        config: of the policy; ``instructions`` are the known answers.

    Raises:
        LlakeyError: if no model is named, the address holds a secret, known instructions are to be listed and none are
            known, or the ``openai`` package is not installed.
    """

    def __init__(self, config: LlakeyCommandConfig) -> None:
        check_address(config.base_url, config.model)
        self.settings = config.chat
        self._views, self._history = tuple(config.cameras), bool(config.history)
        self._guidance = _guidance(config)
        self._client = ChatClient(config.base_url, str(config.model), config.chat, config.max_new_tokens, config.rules)

    @property
    def counts(self) -> ChatCounts:
        """What happened to the requests so far."""
        return self._client.counts

    @cached_property
    def _examples(self) -> list[Message]:
        # At the first question: a saved policy loads where the examples' dataset is not at hand.
        examples = draw_examples(self.settings, self._views, self._history)
        return solved(examples, self.settings.image_format)

    def answers(self, images: Tensor, prompts: Sequence[Prompt]) -> list[str]:
        """What the model says to each row; see :meth:`ChatClient.ask_all` for empty answers and errors.

        Args:
            images: (B, V, 3, H, W) in 0..1.
            prompts: one a row.
        """
        conversations = [
            [
                system_message(prompt, self._guidance),
                *self._examples,
                question(prompt, shown, self.settings.image_format),
            ]
            for prompt, shown in zip(prompts, images, strict=True)
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
