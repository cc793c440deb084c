"""The file of keyframes: what a person says of each, in CSV that a spreadsheet opens and ``llakey annotate`` reads.

One row a keyframe, with the columns :data:`COLUMNS`. ``episode``, ``frame`` and ``instruction`` count; the others are
for people. A file without ``frame`` (``episode,segment,instruction``) tells the instructions of discovered keyframes.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading, write_whole

COLUMNS = ("episode", "segment", "frame", "time", "gripper", "task", "instruction")


@dataclass(frozen=True, order=True)
class Keyframe:
    """The end of a segment.

    Attributes:
        frame: index within the episode, above 0.
        instruction: what is done until then; empty where nothing was said yet.
    """

    frame: int
    instruction: str = ""


Keyframes = tuple[Keyframe, ...]
"""Of one episode, by increasing frame; the last one is the episode's last frame."""


def discovered(episode: FoundKeyframes, texts: Sequence[str] | None = None) -> Keyframes:
    """An episode's keyframes before a person has said anything, with instructions that are known otherwise."""
    return tuple(map(Keyframe, episode.keyframes, texts or [""] * len(episode.keyframes)))


def write_keyframes(path: Path, found: Iterable[FoundKeyframes], keyframes: Mapping[int, Keyframes]) -> None:
    """Write the file, as a whole or not at all.

    Args:
        path: of the file.
        found: the episodes.
        keyframes: by episode, of each of them.

    Raises:
        LlakeyError: if it cannot be written.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(COLUMNS)
    for episode in found:
        for segment, keyframe in enumerate(keyframes[episode.episode]):
            time = f"{keyframe.frame / episode.fps:.2f}"
            gripper = "open" if episode.opened[keyframe.frame] else "closed"
            place = episode.episode, segment, keyframe.frame, time, gripper, episode.task
            writer.writerow((*place, keyframe.instruction))
    write_whole(path, text.getvalue())


@dataclass(frozen=True)
class Row:
    """One row of the file.

    Attributes:
        line: number in the file.
        episode: index.
        number: the keyframe's frame, or its segment in a file without frames.
        instruction: what is done until then; empty where nothing was said yet.
    """

    line: int
    episode: int
    number: int
    instruction: str


def read_rows(path: Path) -> tuple[str, list[Row]]:
    """The rows as they stand, and what their numbers are: "frame", or "segment" in a file without frames.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if a column is missing, a number is none, or a keyframe stands there twice.
    """
    with reading(path, "CSV file of keyframes"), path.open(newline="", encoding="utf-8-sig") as file:
        table = csv.DictReader(file)
        names = tuple(table.fieldnames or ())
        lines = [(table.line_num, row) for row in table]
    column = "frame" if "frame" in names else "segment"
    needed = ("episode", column, "instruction")
    if not set(needed) <= set(names):
        raise LlakeyError(
            f"Expected the columns {', '.join(needed)} in {path}, got {', '.join(names) or 'none'}; correct its first "
            "line."
        )
    rows: dict[tuple[int, int], Row] = {}
    for line, row in lines:
        where = f"in line {line} of {path}"
        episode, number = (_whole(row[name], name, where) for name in needed[:2])
        if (episode, number) in rows:
            raise LlakeyError(
                f"Expected {column} {number} of episode {episode} once, got it again {where}; remove one."
            )
        rows[episode, number] = Row(line, episode, number, (row["instruction"] or "").strip())
    return column, list(rows.values())


def read_keyframes(path: Path, found: Sequence[FoundKeyframes]) -> dict[int, Keyframes]:
    """Every episode's keyframes: the file's, and the discovered ones of episodes that it leaves out.

    A last frame that the file leaves out is added without an instruction.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it is no such file, or names episodes or frames that are not there.
    """
    column, rows = read_rows(path)
    episodes = {episode.episode: episode for episode in found}
    told: dict[int, dict[int, str]] = {}
    for row in rows:
        where, number, place = f"in line {row.line} of {path}", row.episode, row.number
        if number not in episodes:
            raise LlakeyError(
                f"Expected an episode of the dataset's {len(episodes)} {where}, got {number}; remove the row."
            )
        episode = episodes[number]
        if column == "segment":
            if not 0 <= place < len(episode.keyframes):
                raise LlakeyError(
                    f"Expected a segment below {len(episode.keyframes)} {where}, as many as were found in episode "
                    f"{number}, got {place}; correct it, or say frames in a column frame."
                )
            place = episode.keyframes[place]
        if not 0 < place < len(episode.states):
            raise LlakeyError(
                f"Expected a frame from 1 to {len(episode.states) - 1}, the last of episode {number}, {where}, got "
                f"{place}; correct or remove the row."
            )
        told.setdefault(number, {})[place] = row.instruction
    keyframes = {}
    for number, episode in episodes.items():
        # A file without frames may leave segments out; they stay keyframes.
        given = dict.fromkeys(episode.keyframes, "") if column == "segment" else {len(episode.states) - 1: ""}
        given |= told.get(number, {})
        keyframes[number] = tuple(sorted(Keyframe(*item) for item in given.items()))
        if number not in told:
            keyframes[number] = discovered(episode)
    return keyframes


def _whole(text: str | None, name: str, where: str) -> int:
    try:
        return int((text or "").strip())
    except ValueError as error:
        raise LlakeyError(f"Expected a whole number as {name} {where}, got {text!r}; correct it.") from error
