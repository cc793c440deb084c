"""Reads the text columns of a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey.errors import LlakeyError


def text_column(batch: Mapping[str, Any], key: str, default: Sequence[str] | None = None) -> list[str]:
    """A text column of a batch, one str a row.

    Args:
        batch: what a loader or an environment gives.
        key: the column's name.
        default: what stands for a missing column.

    Raises:
        ValueError: if the column is missing and there is no default.
    """
    value = batch.get(key, default)
    if value is None:
        raise LlakeyError(
            f"Expected {key!r} in the batch, got {sorted(batch)}; use a dataset or environment that has it."
        )
    return [value] if isinstance(value, str) else [str(text) for text in value]
