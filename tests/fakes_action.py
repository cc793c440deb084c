"""Batches in the data contract for tests of the action policy."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from lerobot.utils.feature_utils import dataset_to_policy_features
from torch import Tensor

from fakes import fake_action, fake_frame
from lerobot_llakey import schema
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig


def observation(rows: int, seed: int = 0, image_size: int = 32) -> tuple[dict[str, Any], Tensor, list[str]]:
    """A batch as LeRobot's loader gives it (grasp the first of two balls), the centres (B, 2, 3) and the names."""
    rng = np.random.default_rng(seed)
    frames = [fake_frame(rng, image_size) for _ in range(rows)]
    batch: dict[str, Any] = {}
    for key in frames[0]:
        if key.startswith("_"):
            continue
        value = torch.from_numpy(np.stack([frame[key] for frame in frames])).float()
        if "images" in key:
            value = value.permute(0, 3, 1, 2) / (1 if key.endswith("_depth") else 255)
        batch[key] = value.contiguous()
    names = [str(frame["_names"][0]) for frame in frames]
    centres = np.stack([frame["_centres"] for frame in frames])
    batch[schema.ACTION] = torch.from_numpy(np.stack([fake_action(c[0], gripper_open=False) for c in centres]))
    batch[schema.INSTRUCTION] = [f"grasp the {name} block" for name in names]
    batch[schema.TASK] = [f"pick up the {name} block" for name in names]
    return batch, torch.from_numpy(centres).float(), names


def small_config(**settings: Any) -> LlakeyActionConfig:
    """A network small enough for tests, for the features of a keysteps dataset at 32 pixels."""
    features = dataset_to_policy_features(
        schema.dataset_features(dict.fromkeys(schema.CAMERAS, (32, 32)), dtype="image")
    )
    small = {
        "view_size": 64,
        "rotation_blur": 0.0,
        "widths": [16, 24, 32],
        "blocks": [1, 1],
        "transformer_layers": 1,
        "transformer_heads": 2,
        "text_width": 32,
        "text_layers": 1,
        "device": "cpu",
        "dtype": "float32",
        "cameras": list(schema.CAMERAS),
        "state_names": list(schema.SIM_STATE_NAMES),
        "workspace": [list(bounds) for bounds in schema.WORKSPACE],
    }
    return LlakeyActionConfig(
        input_features={key: value for key, value in features.items() if key != schema.ACTION},
        output_features={schema.ACTION: features[schema.ACTION]},
        **(small | settings),
    )
