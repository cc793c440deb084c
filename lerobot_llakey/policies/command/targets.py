"""What the command policy is trained to answer: the next basic action in words, or the next keyframe's pose."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import read_actions
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.decoding.trie import Node, Trie
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.pose_text import DIGITS, PoseText
from lerobot_llakey.policies.texts import text_column

_JOINED = (
    "Expected a tokenizer that tells numbers of three digits apart, one after the other, got one that does not; use "
    "target=instruction with this model."
)


class Target(ABC):
    """What the command policy is trained to answer."""

    @abstractmethod
    def answers(self, batch: Mapping[str, Any]) -> list[str]:
        """The correct answer for each row of a training batch.

        Raises:
            LlakeyError: if the batch lacks the column that the answer comes from.
        """

    @abstractmethod
    def trie(self, encoder: Encoder) -> Trie:
        """All possible answers as tokens of an encoder; empty if they are not known."""


class InstructionTarget(Target):
    """The paper's target: the next basic action in words.

    Args:
        known: the instructions found in the training dataset or listed in the settings.
    """

    def __init__(self, known: Sequence[str]) -> None:
        self.known = list(known)

    def answers(self, batch: Mapping[str, Any]) -> list[str]:
        return text_column(batch, schema.INSTRUCTION)

    def trie(self, encoder: Encoder) -> Trie:
        return Trie(encoder.answer(text) for text in self.known)


class ActionTarget(Target):
    """Direct actions: the next keyframe's pose, gripper and collision flag as numbers.

    The numbers are plain text, not reserved tokens of a pretrained vocabulary (RT-2 does either, depending on its
    model). So every tokenizer works unchanged, and a pretrained model's knowledge of digits is of use. The small
    tokenizer has one token for each number, so an answer takes ten tokens.

    Args:
        text: how the numbers are written.
    """

    def __init__(self, text: PoseText) -> None:
        self.text = text

    def answers(self, batch: Mapping[str, Any]) -> list[str]:
        return [self.text.encode(action) for action in read_actions(batch).double().cpu().numpy()]

    def trie(self, encoder: Encoder) -> Trie:
        """Every text of nine legal numbers; all values of one number share the subtree that follows it."""
        count = len(self.text.sizes)
        after: Node = {encoder.stop_id: {}}
        for place in reversed(range(count)):
            node: Node = {}
            for number in self.text.numbers[: self.text.sizes[place]]:
                _add(node, _tokens(encoder, number, place), after)
            after = node
        trie = Trie([])
        trie.root = after
        return trie


def _tokens(encoder: Encoder, number: str, place: int) -> list[int]:
    """The tokens of a number at one place of an answer."""
    first = ["0" * DIGITS] * place
    before = encoder.answer(" ".join(first))[:-1] if first else []
    whole = encoder.answer(" ".join([*first, number]))[:-1]
    if whole[: len(before)] != before or len(whole) == len(before):
        raise LlakeyError(_JOINED)
    return whole[len(before) :]


def _add(node: Node, tokens: list[int], after: Node) -> None:
    *inner, last = tokens
    for token in inner:
        node = node.setdefault(token, {})
    if last in node or node is after:
        raise LlakeyError(_JOINED)
    node[last] = after


def make_target(config: LlakeyCommandConfig) -> InstructionTarget | ActionTarget:
    """The target chosen by the settings."""
    if config.target == "action":
        return ActionTarget(PoseText(config.action_bins, config.box))
    return InstructionTarget(config.instructions)


def check_answer_lengths(config: LlakeyCommandConfig, encoder: Encoder) -> None:
    """Refuse known instructions with more tokens than ``max_new_tokens``.

    Raises:
        LlakeyError: naming the longest.
    """
    lengths = {text: len(encoder.answer(text)) for text in config.instructions}
    longest = max(lengths, key=lambda text: lengths[text], default="")
    if longest and lengths[longest] > config.max_new_tokens:
        raise LlakeyError(
            f"Expected max_new_tokens of at least {lengths[longest]}, which {longest!r} takes, got "
            f"{config.max_new_tokens}; raise it."
        )
