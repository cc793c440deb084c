"""What the loop decides before anything moves: an instruction for each row, and whose it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import Instruction


@dataclass(frozen=True)
class Said:
    """One instruction as its commander gave it.

    Attributes:
        text: the words, before anyone reads them.
        source: who said it: "policy", "oracle", "task", "list" or "person".
        likelihood: how likely the words were to who said them, in 0..1; None where that has no meaning.
    """

    text: str
    source: str
    likelihood: float | None = None


@dataclass(frozen=True)
class Choice:
    """The instruction that one row will carry out.

    Attributes:
        instruction: in its canonical wording.
        parsed: the same, as the grammar reads it.
        source: who said it, or "fallback" or "previous", see
            :class:`~lerobot_llakey.policies.hierarchy.step_log.Step`.
        said: the commander's own words.
        likelihood: of the words; None where that has no meaning or others took their place.
        unparsable: whether the words were outside the grammar, so that others took their place.
    """

    instruction: str
    parsed: Instruction
    source: str
    said: str
    likelihood: float | None = None
    unparsable: bool = False


@dataclass(frozen=True, eq=False)
class Decision:
    """What all B rows of a batch will carry out. It holds all that a step needs, and nothing remembers it.

    Attributes:
        batch: what the action policy is given: the observation with the goals that hold, and the instructions.
        hands: (B, 8) before the step: position in metres, quaternion xyzw, gripper opening.
        goals: the skill instruction of each row, "" where there is none.
        choices: one for each row.
        answers: all that the commander has answered about this observation, by row and goal.
    """

    batch: dict[str, Any]
    hands: np.ndarray
    goals: list[str]
    choices: list[Choice]
    answers: Mapping[tuple[int, str], Said]


def choose(said: Said, last: Choice | None, grammar: Grammar, fallback: str | None) -> Choice:
    """What is carried out where these words were said; a text outside the grammar leaves the last choice standing.

    Args:
        said: the words.
        last: what was carried out before, None at the first step.
        grammar: which texts are instructions.
        fallback: an instruction for where nothing valid was said yet; with None the arm keeps still: an error says so.

    Raises:
        LlakeyError: if nothing was ever said that can be read, and there is no fallback.
    """
    parsed = grammar.parsed_or_none(said.text)
    if parsed is not None:
        return Choice(grammar.canonical(parsed), parsed, said.source, said.text, said.likelihood)
    if last is not None:
        return replace(last, source="previous", said=said.text, likelihood=None, unparsable=True)
    if fallback is None:
        raise LlakeyError(
            f"Expected an instruction of {grammar.name}, got {said.text[:80]!r} and none before it, so the arm keeps "
            "still; set --policy.fallback_instruction to what is done then."
        )
    return Choice(fallback, grammar.parse(fallback), "fallback", said.text, unparsable=True)
