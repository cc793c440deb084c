"""Instructions that a person gives to recordings: from a file that was filled in, or typed."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import replacing
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hints import nearest_forms
from lerobot_llakey.instructions import BASIC_GRAMMAR

COLUMNS = ("episode", "segment", "from_second", "to_second", "instruction")
"""Columns of the CSV file that :func:`write_template` writes; reading needs the first two and the last."""


def write_template(found: Sequence[FoundKeyframes], path: Path) -> None:
    """Write a CSV file with one line a segment, its instruction left empty for a person to fill in.

    Raises:
        LlakeyError: if it cannot be written.
    """
    with replacing(path) as fresh, fresh.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for episode in found:
            for segment in range(len(episode.keyframes)):
                begin, end = episode.seconds(segment)
                writer.writerow((episode.episode, segment, f"{begin:.1f}", f"{end:.1f}", ""))


def read_instructions(path: Path, grammar: Grammar = BASIC_GRAMMAR) -> dict[int, list[str]]:
    """Instructions by episode, in the order of segments, from a CSV or JSON file.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it is not of the form that :mod:`lerobot_llakey.datasets.annotate` gives, or instructions in it
            are outside the grammar.
    """
    if not path.exists():
        raise MissingFileError(f"Expected instructions in {path}, found no file; write one with --template={path}.")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise LlakeyError(f"Expected {path} in UTF-8, got other bytes ({error.reason}); save it as UTF-8.") from error
    return _from_json(path, text, grammar) if path.suffix == ".json" else _from_csv(path, text, grammar)


def _from_json(path: Path, text: str, grammar: Grammar) -> dict[int, list[str]]:
    try:
        found = {int(episode): [str(one) for one in texts] for episode, texts in json.loads(text).items()}
    except (AttributeError, RecursionError, TypeError, ValueError) as error:
        raise LlakeyError(
            f'Expected {path} to hold {{"0": ["instruction", ...], ...}}, got something else ({error}); correct it.'
        ) from error
    refuse_outside_grammar(by_place(found), f" in {path}", grammar)
    return found


def _from_csv(path: Path, text: str, grammar: Grammar) -> dict[int, list[str]]:
    rows = csv.DictReader(text.splitlines(keepends=True))
    by_segment: dict[tuple[int, int], str] = {}
    lines: dict[str, str] = {}
    try:
        for row in rows:
            place = int(row["episode"]), int(row["segment"])
            if place in by_segment:
                raise LlakeyError(
                    f"Expected segment {place[1]} of episode {place[0]} once in {path}, got it again in line "
                    f"{rows.line_num}; remove one."
                )
            by_segment[place] = lines[f"line {rows.line_num}"] = row["instruction"].strip()
    except LlakeyError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError, csv.Error) as error:
        raise LlakeyError(
            f"Expected {path} to have the columns episode, segment and instruction, got a row without ({error}); "
            "correct it."
        ) from error
    found: dict[int, list[str]] = {}
    for episode, segment in sorted(by_segment):
        if segment != len(found.setdefault(episode, [])):
            raise LlakeyError(
                f"Expected segment {len(found[episode])} of episode {episode} in {path}, got segment {segment}; "
                "number the segments from 0 without gaps."
            )
        found[episode].append(by_segment[episode, segment])
    refuse_outside_grammar(lines, f" in {path}", grammar)
    return found


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
