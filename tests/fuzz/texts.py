"""Texts that are no basic action, of any length and script."""

from __future__ import annotations

import string
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from fuzz.case import Case

_WORDS = (
    "rotate",
    "the",
    "to",
    "a",
    "grasp",
    "cup",
    "red",
    "and",
    "move",
    "top",
    "of",
    "抓住",
    "杯子",
    "\x00",
    "\x1b[31m",
)


def _parse(text: str, _: Path) -> None:
    from lerobot_llakey import instructions

    instructions.parse(text)


def _hint(text: str, _: Path) -> None:
    from lerobot_llakey.drive.hints import read_instruction

    read_instruction(text)


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Random words, repeated beginnings, other scripts, control characters; long and short."""
    for length in (0, 1, 3, 30, 300, 3_000, 30_000, 300_000):
        shuffled = " ".join(rng.choice(_WORDS, size=length))
        noise = "".join(rng.choice(list(string.printable), size=length))
        for kind, text in (
            ("words", f"zz {shuffled}"),
            ("characters", f"zz{noise}"),
            ("repeated", "zz rotate the " + "a to the " * length),
            ("digits", "1. " * length),
            ("spaces", " " * length),
            ("chinese", "抓住杯子" * max(length, 1)),
            ("surrogates", "\ud800" * max(length, 1)),
        ):
            for verb, act in (("parse", _parse), ("hint", _hint)):
                yield Case("text", f"{verb}: {length} {kind}", partial(act, text))
