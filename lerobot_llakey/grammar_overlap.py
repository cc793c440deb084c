"""Whether two wordings could read one text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

SLOT = re.compile(r"\{([a-z]\w{0,30})\}")
"""Where an argument stands in a wording."""
_OTHER = "\0"
"""Stands for any word that no wording holds."""
_State = tuple[int, tuple[str, ...]]
"""Place in a wording, and what is still to come of a pose (or "" within a phrase)."""


def fits_both(first_wording: str, second_wording: str, poses: Sequence[str], joining: frozenset[str]) -> str | None:
    """A text that fits both wordings, None if there is none: both are walked at once, word by word, as automata.

    Args:
        first_wording: words, and slots like ``{thing}``.
        second_wording: the same.
        poses: what ``{pose}`` may be.
        joining: words that no other slot may hold.
    """
    one, other = first_wording.split(), second_wording.split()
    if SLOT.fullmatch(one[0]) is None and SLOT.fullmatch(other[0]) is None and one[0] != other[0]:
        return None
    alphabet = [*{*one, *other, *(word for pose in poses for word in pose.split())}, _OTHER]
    alphabet = sorted(word for word in alphabet if not SLOT.fullmatch(word))
    start: tuple[_State, _State] = ((0, ()), (0, ()))
    found: dict[tuple[_State, _State], str] = {start: ""}
    todo = [start]
    while todo:
        pair = todo.pop()
        if pair[0] == (len(one), ()) and pair[1] == (len(other), ()):
            return found[pair].strip().replace(_OTHER, "thing")
        for word in alphabet:
            for first in _after(pair[0], word, one, poses, joining):
                for second in _after(pair[1], word, other, poses, joining):
                    if (first, second) not in found:
                        found[first, second] = f"{found[pair]} {word}"
                        todo.append((first, second))
    return None


def _after(
    state: _State, word: str, wording: list[str], poses: Sequence[str], joining: frozenset[str]
) -> Iterator[_State]:
    """Where one more word leads from a place in a wording."""
    place, left = state
    if left:
        if left[0] == word:
            yield (place, left[1:]) if left[1:] else (place + 1, ())
        return
    if place == len(wording):
        return
    slot = SLOT.fullmatch(wording[place])
    if slot is None:
        if wording[place] == word:
            yield place + 1, ()
    elif slot[1] == "pose":
        for pose in poses:
            first, *rest = pose.split()
            if first == word:
                yield (place, tuple(rest)) if rest else (place + 1, ())
    elif word not in joining:
        yield place, ()
        yield place + 1, ()
