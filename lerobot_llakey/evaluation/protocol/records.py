"""What each episode came to, kept line by line in a file that survives being killed at any moment."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Trial
from lerobot_llakey.rollout.episode import Episode

EPISODES = "episodes.jsonl"
"""The file of records in a table's folder."""
COMMAND, ACTION = "command", "action"
"""Which level a failure is put down to."""


@dataclass(frozen=True)
class Record:
    """One finished episode.

    Attributes:
        trial: which one.
        episode: what happened; with its actions it can be run again to the last bit.
        attribution: COMMAND or ACTION where the episode failed and the policy has two levels, else empty.
        swapped_at: the step at which the oracle's instruction took the place of the policy's, None where never.
        seconds: that it all took.
    """

    trial: Trial
    episode: Episode
    attribution: str
    swapped_at: int | None
    seconds: float

    def to_line(self) -> str:
        """One line of JSON, without its end."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_line(line: str) -> Record:
        """Inverse of :meth:`to_line`.

        Raises:
            LlakeyError: if the line does not hold a record.
        """
        try:
            content = json.loads(line)
            return Record(
                Trial(**content["trial"]),
                Episode(**content["episode"]),
                content["attribution"],
                content["swapped_at"],
                content["seconds"],
            )
        except (KeyError, TypeError, ValueError) as error:
            raise LlakeyError(f"Expected the record of an episode, got {line[:80]!r}; delete that line.") from error


class Records:
    """The finished episodes of a table, in a file of JSON lines.

    A line is written in one piece and flushed to the disk before the episode counts as finished. A line that was only
    half written when a run was killed does not count and is cut off by the next record; reading alone changes nothing.

    Args:
        path: the file; made where it is missing.

    Raises:
        LlakeyError: if a line other than the last is no record.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.records: dict[tuple[str, str, str, int, int], Record] = {}
        content = path.read_bytes() if path.exists() else b""
        self._end: int | None = content.rfind(b"\n") + 1
        for line in content[: self._end].decode().splitlines():
            record = Record.from_line(line)
            self.records.setdefault(record.trial.key, record)

    def __contains__(self, trial: object) -> bool:
        return isinstance(trial, Trial) and trial.key in self.records

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records.values())

    def add(self, record: Record) -> None:
        """Keep a record for good.

        Raises:
            ValueError: if the episode has one already.
        """
        if record.trial in self:
            raise ValueError(f"Expected each episode once, got {record.trial} again; this is a mistake of the program.")
        file = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            if self._end is not None:  # the first record of this run
                os.ftruncate(file, self._end)
                self._end = None
            line = f"{record.to_line()}\n".encode()
            while line:
                line = line[os.write(file, line) :]
            os.fsync(file)
        finally:
            os.close(file)
        self.records[record.trial.key] = record
