"""One wrong input, and what must come of it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

SENTENCE = re.compile(r"Expected .+(, got |, found |, which |, but |: ).+", re.DOTALL)
"""The form of every error that a person can mend: what was expected, what came."""

GOOD = ("sentence", "warned", "right")
BAD = ("silent", "traceback", "signal", "hang", "vague")
"""Outcomes. "vague" is a sentence that does not name what came."""


@dataclass(frozen=True)
class Case:
    """A wrong input.

    Attributes:
        kind: the group that it is counted in.
        name: what is wrong, unique within its kind.
        act: hands it in as a person would, in an empty scratch folder. It returns nothing, unless the input was put
            right and the result was compared with the right one; then it returns "right", or "warned".
        names: texts of which the sentence must hold at least one; any sentence will do where empty.
    """

    kind: str
    name: str
    act: Callable[[Path], str | None]
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes:
        case: which one.
        result: out of GOOD and BAD.
        text: the sentence, or what else was said.
        seconds: that it took.
    """

    case: Case
    result: str
    text: str
    seconds: float


def judge(case: Case, raised: BaseException | None, answer: str | None, said: str) -> tuple[str, str]:
    """The result and the text of a case that ended by itself.

    Args:
        case: which one.
        raised: the error that it ended with.
        answer: what ``act`` returned.
        said: on stderr.
    """
    from lerobot_llakey.errors import LlakeyError

    if raised is None:
        return (answer, said) if answer in GOOD else ("silent", said)
    if isinstance(raised, SystemExit):
        lines = [line for line in said.splitlines() if line.startswith("error: ")]
        refused = [line for line in said.splitlines() if line.startswith("| refused")]
        if raised.code == 1 and refused and not lines:  # the table of llakey check
            named = any(name.lower() in line.lower() for line in refused for name in case.names)
            return "sentence" if named else "vague", " ".join(refused)
        if raised.code in (1, 2) and len(lines) == 1:
            return _sentence(case, lines[0].removeprefix("error: "))
        return "traceback", f"exit status {raised.code}: {said[-300:]}"
    if isinstance(raised, LlakeyError):
        return _sentence(case, str(raised))
    return "traceback", f"{type(raised).__name__}: {raised}"


def _sentence(case: Case, text: str) -> tuple[str, str]:
    named = not case.names or any(name.lower() in text.lower() for name in case.names)
    return ("sentence" if SENTENCE.match(text) and named else "vague"), text
