"""Keysteps, the training samples of the paper, drawn from a dataset of demonstrations."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.constants import DEFAULT_FEATURES
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.datasets.balance import PAPER, Balance
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.folders import new_folder, refuse_occupied


def convert(source: LeRobotDataset, root: Path, repo_id: str, *, balance: Balance = PAPER, seed: int = 0) -> int:
    """Write the keysteps of a demonstrations dataset, simulated or real, as a dataset of their own.

    It appears whole or not at all; a run after one that was killed begins anew.

    Args:
        source: demonstrations with the contract's keyframe and instruction columns; any cameras.
        root: folder of the keysteps, which must not exist yet.
        repo_id: their name.
        balance: which frames are taken and what they count.
        seed: of the random choices.

    Returns:
        Number of keysteps.

    Raises:
        LlakeyError: if a column is missing, or the folder cannot be written to.
        FileInTheWayError: if the folder exists.
    """
    refuse_occupied(root)
    missing = [key for key in (schema.NEXT_KEYFRAME, schema.INSTRUCTION, schema.ACTION) if key not in source.features]
    if missing:
        raise LlakeyError(
            f"Expected demonstrations with keyframes and instructions, got {source.repo_id} without "
            f"{', '.join(missing)}; annotate it with llakey annotate."
        )
    features = {
        key: {**feature, "dtype": "image", "info": _info(feature)} if feature["dtype"] == "video" else dict(feature)
        for key, feature in source.features.items()
        if key not in DEFAULT_FEATURES
    }
    written = features | balance.features()
    columns = source.hf_dataset.with_format("numpy")
    next_frames, episodes = np.array(columns[schema.NEXT_KEYFRAME]), np.array(columns["episode_index"])
    rng = np.random.default_rng(seed)
    count = 0
    with (
        new_folder(root) as folder,
        ImageDatasetWriter(repo_id, folder, source.fps, written, source.meta.robot_type) as writer,
    ):
        for episode in tqdm(np.unique(episodes), desc="keysteps", unit="episode"):
            rows = np.flatnonzero(episodes == episode)
            keyframes = sorted(set(next_frames[rows].tolist()))
            chosen = balance.select(keyframes, len(rows), rng)
            frames = {
                frame: _frame(source[int(rows[frame])], features) | balance.columns(frame, keyframes)
                for frame in sorted(set(chosen))
            }
            writer.add_episode([frames[frame] for frame in chosen])
            count += len(chosen)
    return count


def _info(feature: Mapping[str, Any]) -> dict[str, Any] | None:
    """What remains true of a video's notes once it is pictures."""
    is_depth = (feature.get("info") or {}).get("is_depth_map", False)
    return {"is_depth_map": True} if is_depth else None


def _frame(item: Mapping[str, Any], features: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """A loaded item, as it has to be written again."""
    frame: dict[str, Any] = {schema.TASK: item[schema.TASK]}
    for key, feature in features.items():
        value = item[key]
        if feature["dtype"] == "image":
            pixels = value.permute(1, 2, 0).numpy()
            is_depth = pixels.shape[-1] == 1
            frame[key] = np.rint(pixels if is_depth else pixels * 255).astype(np.uint16 if is_depth else np.uint8)
        elif feature["dtype"] == "string":
            frame[key] = value
        else:
            frame[key] = np.asarray(value, dtype=feature["dtype"]).reshape(feature["shape"])
    return frame
