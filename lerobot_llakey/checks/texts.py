"""Words that a policy can be taught, and that can be carried out later."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.checks.columns import Columns
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.sentences import LONGEST_SENTENCE

LONGEST_TASK = 1000
_CONTROL = re.compile(r"<\|?[\w/ ]{1,40}\|?>|\[/?INST\]")
"""What language models read as a command and not as words: stop tokens, image tokens, turns of a chat."""
_SHOWN = 3


def check_instructions(columns: Columns, reads: Collection[str], grammar: Grammar) -> Iterator[Finding]:
    """Instructions are there, of the dataset's grammar, and no commands to a language model."""
    for key in (schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION):
        if key not in columns or key not in reads:
            continue
        texts = columns[key]
        missing = np.array([text is None for text in texts], dtype=bool)
        if missing.any():
            yield Finding(key, "a text in every row", "none", "annotate these rows", columns.place(missing))
        counts = Counter(str(text) for text in texts if text is not None)
        for expected, advice, wrong in _faults(
            counts,
            LONGEST_SENTENCE if grammar.is_free else schema.TEXT_LENGTH,
            optional=key != schema.INSTRUCTION,
            grammar=grammar,
        ):
            marks = np.array([text in wrong for text in texts], dtype=bool)
            yield Finding(key, expected, _listed(wrong), advice, columns.place(marks))


def check_segments(columns: Columns, reads: Collection[str]) -> Iterator[Finding]:
    """The frames that lead to one keyframe carry one instruction; after an event it may change on the way."""
    key = schema.INSTRUCTION
    if key not in reads or not columns.has(key, schema.KEYFRAME_INDEX):
        return
    several = changed = 0
    mixed = np.zeros(len(columns), dtype=bool)
    for rows in columns.episodes():
        segments = columns[schema.KEYFRAME_INDEX][rows]
        for segment in np.unique(segments):
            place = np.flatnonzero(segments == segment) + rows.start
            differ = len(set(columns[key][place])) > 1
            several, changed = several + (len(place) > 1), changed + differ
            mixed[place] = differ
    if changed > several / 2:
        expected, got = "one instruction for all frames of a segment", f"several in {changed} of {several} segments"
        yield Finding(key, expected, got, "label the frames anew", columns.place(mixed))


def check_tasks(tasks: Collection[str]) -> Iterator[Finding]:
    """Skill instructions are words."""
    counts = Counter(str(task) for task in tasks)
    empty = [task for task in counts if not task.strip()]
    if empty:
        yield Finding(schema.TASK, "words", "an empty text", "name the task in meta/tasks.parquet")
    for expected, advice, wrong in _faults(counts, LONGEST_TASK, optional=True):
        yield Finding(schema.TASK, expected, _listed(wrong), advice)


def _faults(
    texts: Collection[str], longest: int, *, optional: bool, grammar: Grammar | None = None
) -> Iterator[tuple[str, str, list[str]]]:
    """What is wrong with texts: what was expected, what to do, and the texts."""
    long = [text for text in texts if len(text) > longest]
    if long:
        yield f"at most {longest} characters", "shorten them", long
    short = [text for text in texts if len(text) <= longest]
    control = [text for text in short if _CONTROL.search(text)]
    if control:
        yield "plain words without tokens of a language model", "leave these out", control
    known = [text for text in short if text not in control]
    if grammar is None:
        return
    wrong = [text for text in known if not grammar.is_parsable(text) and (text.strip() or not optional)]
    if wrong:
        advice = "annotate anew with --grammar=free or a grammar file that has a template for them"
        yield f"basic actions of {grammar.name}", advice, wrong


def _listed(texts: list[str]) -> str:
    shown = ", ".join(repr(text if len(text) <= 80 else f"{text[:77]}...") for text in texts[:_SHOWN])
    return shown + (f" and {len(texts) - _SHOWN} others" if len(texts) > _SHOWN else "")
