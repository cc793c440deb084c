"""What tells one episode from another without being told: its first observation."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import blake2b
from typing import Any

import torch

from lerobot_llakey import schema


def episode_key(batch: Mapping[str, Any], row: int) -> int:
    """A number below 2**64 that depends on a row's goal, state and pictures alone, not on the row's place in the batch.

    Random moves are seeded with it, so that an episode goes the same way alone and among others.

    Args:
        batch: the first observation of the episodes.
        row: of the batch.
    """
    digest = blake2b(digest_size=8)
    task = batch.get(schema.TASK, "")
    digest.update((task if isinstance(task, str) else str(task[row])).encode())
    for key in (schema.STATE, *sorted(map(schema.image_key, schema.cameras_of(batch)))):
        value = batch.get(key)
        if isinstance(value, torch.Tensor):
            digest.update(value[row].detach().cpu().float().contiguous().numpy().tobytes())
    return int.from_bytes(digest.digest(), "big")
