"""Instructions that a person gives to recordings: from a file that was filled in, or typed."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.keyframe_file import read_rows
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hints import nearest_forms
from lerobot_llakey.instructions import BASIC_GRAMMAR


@dataclass(frozen=True)
class Wording:
    """What a person wrote into a file.

    Attributes:
        instructions: by episode, in the order of segments.
        keyframes: frames by episode, increasing; None where the file names none, so that the discovered ones count.
    """

    instructions: dict[int, list[str]]
    keyframes: dict[int, list[int]] | None = None


def read_instructions(path: Path, grammar: Grammar = BASIC_GRAMMAR) -> Wording:
    """Instructions by episode, in the order of segments, from a CSV or JSON file; from a CSV file also keyframes.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it is not of the form that :mod:`lerobot_llakey.datasets.annotate` gives, or instructions in it
            are outside the grammar.
    """
    if not path.exists():
        raise MissingFileError(f"Expected instructions in {path}, found no file; write one with --template={path}.")
    if path.suffix != ".json":
        return _from_csv(path, grammar)
    with reading(path, "JSON file of instructions"):
        text = path.read_text(encoding="utf-8-sig")
    return Wording(_from_json(path, text, grammar))


def _from_json(path: Path, text: str, grammar: Grammar) -> dict[int, list[str]]:
    try:
        found = {int(episode): [str(one) for one in texts] for episode, texts in json.loads(text).items()}
    except (AttributeError, RecursionError, TypeError, ValueError) as error:
        raise LlakeyError(
            f'Expected {path} to hold {{"0": ["instruction", ...], ...}}, got something else ({error}); correct it.'
        ) from error
    refuse_outside_grammar(by_place(found), f" in {path}", grammar)
    return found


def _from_csv(path: Path, grammar: Grammar) -> Wording:
    column, rows = read_rows(path)
    refuse_outside_grammar({f"line {row.line}": row.instruction for row in rows}, f" in {path}", grammar)
    found: dict[int, list[str]] = {}
    frames: dict[int, list[int]] = {}
    for row in sorted(rows, key=lambda row: (row.episode, row.number)):
        episode, number = row.episode, row.number
        if column == "segment" and number != len(found.get(episode, ())):
            raise LlakeyError(
                f"Expected segment {len(found.get(episode, ()))} of episode {episode} in {path}, got segment {number}; "
                "number the segments from 0 without gaps."
            )
        found.setdefault(episode, []).append(row.instruction)
        frames.setdefault(episode, []).append(number)
    return Wording(found, frames if column == "frame" else None)


def ask_instructions(
    found: Sequence[FoundKeyframes], ask: Callable[[str], str] = input, grammar: Grammar = BASIC_GRAMMAR
) -> dict[int, list[str]]:
    """Ask a person for every segment's instruction; an empty answer takes the one of the same segment before.

    What is outside the grammar is asked for again, with the nearest form.

    Args:
        found: episodes with their keyframes.
        ask: shows a prompt and returns what was typed.
        grammar: of what may be said.

    Raises:
        LlakeyError: if the input ends before.
    """
    answers: dict[int, list[str]] = {}
    before: dict[tuple[str, int, int], str] = {}
    for episode in found:
        texts: list[str] = []
        count = len(episode.keyframes)
        for segment in range(count):
            begin, end = episode.seconds(segment)
            place = (episode.task, count, segment)
            default = f" [{before[place]}]" if place in before else ""
            question = f"episode {episode.episode} ({episode.task}), {begin:.1f} to {end:.1f} s{default}: "
            prompt, text = question, ""
            while not text:
                try:
                    text = ask(prompt).strip() or before.get(place, "")
                except EOFError as error:
                    raise LlakeyError(
                        f"Expected an instruction for segment {segment} of episode {episode.episode}, got the end of "
                        "the input; type all of them, or give a file with --instructions."
                    ) from error
                if text and not grammar.is_parsable(text):
                    prompt, text = f"not a basic action{_nearest(text, grammar)}. {question}", ""
            before[place] = text
            texts.append(text)
        answers[episode.episode] = texts
    return answers


def by_place(texts: Mapping[int, Sequence[str]]) -> dict[str, str]:
    """Instructions under the names of their segments."""
    return {
        f"episode {episode}, segment {segment}": text
        for episode, spoken in texts.items()
        for segment, text in enumerate(spoken)
    }


def refuse_outside_grammar(texts: Mapping[str, str], where: str = "", grammar: Grammar = BASIC_GRAMMAR) -> None:
    """Refuse instructions that a policy could be trained on, but that would never be carried out; empty ones pass.

    Args:
        texts: instructions by where they stand.
        where: what an error says of all of them.
        grammar: that they must be of.

    Raises:
        LlakeyError: with all that are outside the grammar, where they stand, and the nearest form of each.
    """
    places: dict[str, list[str]] = {}
    for place, text in texts.items():
        if text.strip() and not grammar.is_parsable(text):
            places.setdefault(text, []).append(place)
    if places:
        listed = [f"{text!r} ({', '.join(found)}{_nearest(text, grammar)})" for text, found in places.items()]
        count = sum(map(len, places.values()))
        raise LlakeyError(
            f"Expected basic actions of {grammar.name}, got {count} outside it{where}: {'; '.join(listed)}; correct "
            "them, add a template to a grammar file, or choose --grammar=free."
        )


def _nearest(text: str, grammar: Grammar) -> str:
    forms = nearest_forms(text[:200], 1, grammar)
    return f"; the nearest form is {forms[0]!r}" if forms else ""
