"""Recorded batches as a policy takes them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lerobot_llakey import schema

Preprocessor = Callable[[dict[str, Any]], dict[str, Any]]


def prepared(batch: dict[str, Any], preprocessor: Preprocessor | None) -> dict[str, Any]:
    """A dataset's batch after a policy's preprocessor, with its instructions, which LeRobot's processors drop."""
    processed = preprocessor(batch) if preprocessor else batch
    return processed | {key: batch[key] for key in schema.TEXTS if key in batch}
