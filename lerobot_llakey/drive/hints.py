"""What a person who typed something outside the grammar of basic actions is told."""

from __future__ import annotations

from collections.abc import Iterable

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hints import nearest_forms, nearest_known
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.sentences import shortened


def read_instruction(text: str, known: Iterable[str] = (), grammar: Grammar = BASIC_GRAMMAR) -> str:
    """What a person typed, as a basic action in its canonical wording.

    Args:
        text: as typed.
        known: instructions that the policy was trained on, from which the nearest is suggested.
        grammar: of what may be said.

    Raises:
        LlakeyError: if the text is no basic action; one sentence with the nearest forms.
    """
    try:
        return grammar.canonical(text)
    except LlakeyError as error:
        if grammar.is_free:
            raise
        raise LlakeyError(explain(text, known, grammar)) from error


def explain(text: str, known: Iterable[str] = (), grammar: Grammar = BASIC_GRAMMAR) -> str:
    """The sentence for a text that cannot be read: what came, and what would be read instead."""
    near = nearest_known(text, known)
    hint = f"did you mean {near!r}? The" if near else "the"
    return (
        f"Expected a basic action, got {shortened(text)}; {hint} nearest forms are "
        f"{'; '.join(nearest_forms(text, grammar=grammar))}. Nothing was moved."
    )
