"""Direct actions as a target: the next keyframe's pose, written as numbers.

The numbers are text rather than tokens taken from a pretrained vocabulary (RT-2 does either, by its model): so they
need no change of a tokenizer, keep the order of digits that a language model knows, and work with every model. The
small tokenizer has a word for each number, which makes an answer ten tokens.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import read_actions
from lerobot_llakey.policies.command.decoding.trie import Node, Trie
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.pose_text import DIGITS, PoseText
from lerobot_llakey.policies.command.targets.target import Target

_JOINED = (
    "Expected a tokenizer that tells numbers of three digits apart, one after the other, got one that does not; use "
    "target=instruction with this model."
)


class ActionTarget(Target):
    """The next keyframe's pose, gripper and collision flag as numbers.

    Args:
        text: how they are written.
    """

    def __init__(self, text: PoseText) -> None:
        self.text = text

    def answers(self, batch: Mapping[str, Any]) -> list[str]:
        return [self.text.encode(action) for action in read_actions(batch).double().cpu().numpy()]

    def trie(self, encoder: Encoder) -> Trie:
        """Every text of nine legal numbers; what follows a number is shared by all of its values."""
        places = len(self.text.sizes)
        after: Node = {encoder.stop_id: {}}
        for place in reversed(range(places)):
            node: Node = {}
            for number in self.text.numbers[: self.text.sizes[place]]:
                _add(node, _tokens(encoder, number, place), after)
            after = node
        trie = Trie([])
        trie.root = after
        return trie


def _tokens(encoder: Encoder, number: str, place: int) -> list[int]:
    """The tokens of a number at a place of an answer."""
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
