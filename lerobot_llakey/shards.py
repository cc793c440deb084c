"""Numbered work divided among machines that do not know of one another."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from lerobot_llakey.errors import LlakeyError


@dataclass(frozen=True)
class Shard:
    """One of several parts of equal size into which work is divided, in the order of the work's numbers.

    Attributes:
        number: which one, from 1.
        count: of how many.

    Raises:
        LlakeyError: if there is no such part.
    """

    number: int = 1
    count: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.count:
            raise LlakeyError(
                f"Expected a shard from 1/{self.count} to {self.count}/{self.count}, got {self}; pick one."
            )

    @staticmethod
    def parse(text: str) -> Shard:
        """A shard as typed: "3/16" is the third of sixteen.

        Raises:
            LlakeyError: if the text says none.
        """
        found = re.fullmatch(r"\s*([0-9]{1,9})\s*/\s*([1-9][0-9]{0,8})\s*", text)
        if found is None:
            raise LlakeyError(f"Expected --shard as a number and a count, such as 3/16, got {text!r}; write it so.")
        return Shard(int(found[1]), int(found[2]))

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    @property
    def name(self) -> str:
        """For folders; sorted by name, shards are sorted by number."""
        return f"{self.number:0{len(str(self.count))}d}-of-{self.count}"

    def of(self, length: int) -> range:
        """The numbers that are this shard's out of ``range(length)``.

        Raises:
            LlakeyError: if there are more shards than numbers.
        """
        if self.count > length:
            raise LlakeyError(f"Expected at most {length} shards of {length} episodes, got {self}; divide by less.")
        return range(length * (self.number - 1) // self.count, length * self.number // self.count)

    def recorded(self, length: int) -> dict[str, Any]:
        """What tells a shard's results from another's: nothing where it is the whole work of ``length`` episodes."""
        if self == WHOLE:
            return {}
        return {"shard": {"number": self.number, "count": self.count, "episodes": length}}


WHOLE = Shard()
"""All of the work."""
