"""From what a chat model writes to the text of one instruction."""

from __future__ import annotations

import re
from itertools import islice

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import LONGEST
from lerobot_llakey.policies.command.prompt import STOP

_THOUGHTS = re.compile(r"<think>.*?(</think>|\Z)", re.DOTALL)
_MARKS = re.compile(r"^(?:[-*+>#]+\s|\d+[.)]\s)\s*")
_LABEL = re.compile(r"^(?:answer|instruction|action|next (?:basic )?(?:action|instruction))\s*:\s*", re.IGNORECASE)
_LONGEST_LINE, _MOST_LINES = 2 * LONGEST, 200
"""What is looked at of a long answer: a basic action is short, and what precedes it is some words."""
_WRAPPING = " \t\"'`*_\u201c\u201d\u2018\u2019"


def first_instruction(text: str, grammar: Grammar) -> str:
    """The first line before the stop token that is a basic action, else the first line that holds any words.

    Quotes, Markdown, numbering, a label such as "Answer:" and the thoughts of a reasoning model are taken off.

    Args:
        text: what the model wrote.

    Returns:
        One line, which need not be in the grammar; "" where nothing was written. Long lines are cut, and what stands
        after some hundred lines is not looked at.

    Args:
        text: as the model wrote it.
        grammar: of the answers.
    """
    written = filter(str.strip, _THOUGHTS.sub("", text).partition(STOP)[0].splitlines())
    lines = list(filter(None, (_bare(line.strip()[:_LONGEST_LINE]) for line in islice(written, _MOST_LINES))))
    return next(filter(grammar.is_parsable, lines), lines[0] if lines else "")


def _bare(line: str) -> str:
    """A line without what surrounds the words."""
    before = None
    while line != before:
        before = line
        line = _LABEL.sub("", _MARKS.sub("", line.strip().strip(_WRAPPING)))
        # A full stop may stand inside or outside of quotes.
        line = line[:-1] if line.endswith((".", ",")) else line
    return "" if line.startswith("```") else line
