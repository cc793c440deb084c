"""What comes nearest to a text that is outside the grammar of basic actions."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import LONGEST
from lerobot_llakey.instructions import BASIC_GRAMMAR

_SLOT = re.compile(r"\{(\w+)\}")
_FORMS, _NEAR, _VERB_WEIGHT = 3, 0.6, 2.0


def nearest_known(text: str, known: Iterable[str]) -> str | None:
    """The known instruction that reads most like a text, None if none is near."""
    found = get_close_matches(_plain(text), list(known), n=1, cutoff=_NEAR)
    return found[0] if found else None


def nearest_forms(text: str, count: int = _FORMS, grammar: Grammar = BASIC_GRAMMAR) -> list[str]:
    """The forms of basic actions that read most like a text, best first, as "grasp <thing>"; one for each template.

    Only the words of a form count, not what fills it: its verb, looked for where the text begins, counts twice.
    """
    words = _plain(text).split()
    best = [max(template.texts, key=lambda form: _likeness(words, form)) for template in grammar.templates.values()]
    return [
        _shown(form, grammar.poses)
        for form in sorted(best, key=lambda form: _likeness(words, form), reverse=True)[:count]
    ]


def forms(grammar: Grammar = BASIC_GRAMMAR) -> list[str]:
    """The first form of every basic action, as "grasp <thing>"; none where any sentence is one."""
    return [_shown(template.texts[0], grammar.poses) for template in grammar.templates.values()]


def _likeness(words: list[str], form: str) -> tuple[float, int]:
    """How much of a form's fixed words is found in a text, 0..1, and how many there are, for forms found alike."""
    verb, *others = _SLOT.sub(" ", form).split()
    found = _VERB_WEIGHT * _nearest(verb, words[:2]) + sum(_nearest(word, words) for word in others)
    return found / (_VERB_WEIGHT + len(others)), len(others)


def _nearest(word: str, words: list[str]) -> float:
    return max((SequenceMatcher(None, word, other).ratio() for other in words), default=0.0)


def _shown(form: str, given: Iterable[str]) -> str:
    poses = "|".join(given)
    return _SLOT.sub(lambda slot: f"<{poses}>" if slot[1] == "pose" else f"<{slot[1]}>", form)


def _plain(text: str) -> str:
    """The beginning of a text: what is compared takes the product of the lengths."""
    text = text[:LONGEST]
    return " ".join(text.lower().split()).removesuffix(".")
