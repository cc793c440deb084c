"""Instructions that a person gives to recordings: from a file that was filled in, or typed."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import replacing
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hints import nearest_forms
from lerobot_llakey.instructions import BASIC_GRAMMAR

COLUMNS = ("episode", "segment", "frame", "time", "gripper", "task", "instruction")
"""Columns of the CSV file that :func:`write_template` writes. Reading needs the episode, the instruction, and the frame
or the segment."""


def write_template(found: Sequence[FoundKeyframes], path: Path) -> None:
    """Write a CSV file with one line a keyframe, its instruction left empty for a person to fill in.

    Lines may be deleted, moved to other frames, and added.

    Raises:
        LlakeyError: if it cannot be written.
    """
    with replacing(path) as fresh, fresh.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for episode in found:
            for segment, frame in enumerate(episode.keyframes):
                gripper = "open" if episode.opened[frame] else "closed"
                time = f"{frame / episode.fps:.2f}"
                writer.writerow((episode.episode, segment, frame, time, gripper, episode.task, ""))


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
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise LlakeyError(f"Expected {path} in UTF-8, got other bytes ({error.reason}); save it as UTF-8.") from error
    return Wording(_from_json(path, text, grammar)) if path.suffix == ".json" else _from_csv(path, text, grammar)


def _from_json(path: Path, text: str, grammar: Grammar) -> dict[int, list[str]]:
    try:
        found = {int(episode): [str(one) for one in texts] for episode, texts in json.loads(text).items()}
    except (AttributeError, RecursionError, TypeError, ValueError) as error:
        raise LlakeyError(
            f'Expected {path} to hold {{"0": ["instruction", ...], ...}}, got something else ({error}); correct it.'
        ) from error
    refuse_outside_grammar(by_place(found), f" in {path}", grammar)
    return found


def _from_csv(path: Path, text: str, grammar: Grammar) -> Wording:
    rows = csv.DictReader(text.splitlines(keepends=True))
    texts: dict[tuple[int, int], str] = {}
    lines: dict[str, str] = {}
    try:
        column = "frame" if "frame" in (rows.fieldnames or ()) else "segment"
        for row in rows:
            place = int(row["episode"]), int(row[column])
            if place in texts:
                raise LlakeyError(
                    f"Expected {column} {place[1]} of episode {place[0]} once in {path}, got it again in line "
                    f"{rows.line_num}; remove one."
                )
            texts[place] = lines[f"line {rows.line_num}"] = row["instruction"].strip()
    except LlakeyError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError, csv.Error) as error:
        raise LlakeyError(
            f"Expected {path} to have the columns episode, frame (or segment) and instruction, got a row without "
            f"({error}); correct it."
        ) from error
    found: dict[int, list[str]] = {}
    frames: dict[int, list[int]] = {}
    for episode, number in sorted(texts):
        if column == "segment" and number != len(found.get(episode, ())):
            raise LlakeyError(
                f"Expected segment {len(found.get(episode, ()))} of episode {episode} in {path}, got segment {number}; "
                "number the segments from 0 without gaps."
            )
        found.setdefault(episode, []).append(texts[episode, number])
        frames.setdefault(episode, []).append(number)
    refuse_outside_grammar(lines, f" in {path}", grammar)
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
