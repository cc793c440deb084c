"""The texts of a batch, as every policy reads them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.sentences import LONGEST_SENTENCE, MARKER

_SHOWN = 60


def text_column(
    batch: Mapping[str, Any],
    key: str,
    rows: int | None = None,
    default: Sequence[str] | None = None,
    *,
    may_be_empty: bool = False,
) -> list[str]:
    """A column of texts of a batch, one str a row.

    Args:
        batch: what a loader or an environment gives.
        key: the column's name.
        rows: how many there have to be; None takes as many as there are.
        default: what stands for a missing column.
        may_be_empty: whether a text may hold no words.

    Raises:
        LlakeyError: naming the key and the row if the column is missing without a default, has another length, or holds
            what is no text, an empty text, one of more than ``LONGEST_SENTENCE`` or one with a model's own marker.
    """
    value = batch.get(key, default)
    if value is None:
        raise LlakeyError(
            f"Expected {key!r} in the batch, got {_names(batch)}; use a dataset or environment that has this column."
        )
    texts = [value] if isinstance(value, str) else value
    if not isinstance(texts, Sequence):
        raise LlakeyError(f"Expected {key} as a list of texts, got {type(value).__name__}; give one text a row.")
    if rows is not None and len(texts) != rows:
        raise LlakeyError(
            f"Expected {key} as {rows} texts, one for each batch row, got {len(texts)}; give the policy its words."
        )
    for row, text in enumerate(texts):
        _check(key, row, text, may_be_empty)
    return list(texts)


def reworded(text: str, probability: float, rng: np.random.Generator, grammar: Grammar) -> str:
    """The instruction, replaced with the given probability by a wording drawn from its template's.

    A text outside the grammar, such as a person's own wording, has no other wording and stays as it is.
    """
    if rng.random() >= probability:
        return text
    return grammar.paraphrase(text, rng) if grammar.is_parsable(text) else text


def _check(key: str, row: int, text: Any, may_be_empty: bool) -> None:
    where = f"in batch row {row}"
    if not isinstance(text, str):
        raise LlakeyError(f"Expected a text in {key}, got {text!r} {where}; write the words into the column.")
    if len(text) > LONGEST_SENTENCE:
        raise LlakeyError(
            f"Expected at most {LONGEST_SENTENCE} characters in {key}, got {len(text)} {where} ({text[:_SHOWN]!r}...); "
            "shorten the text."
        )
    if marker := MARKER.search(text):
        raise LlakeyError(
            f"Expected words alone in {key}, got {marker[0]!r} {where}, which language models read as a command of "
            "their own; take it out."
        )
    if not may_be_empty and not text.strip():
        raise LlakeyError(f"Expected words in {key}, got an empty text {where}; give the policy its words.")


def _names(batch: Mapping[str, Any]) -> list[str]:
    return sorted(str(name) for name in batch)
