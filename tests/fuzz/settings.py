"""Settings of the policies and the environment that make no sense."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.case import Case

_NUMBERS = (math.nan, -math.inf, -1e9)


def _make(kind: str, name: str, value: Any, _: Path) -> None:
    from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
    from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
    from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig

    kinds = {
        "action": partial(LlakeyActionConfig, device="cpu"),
        "command": partial(LlakeyCommandConfig, device="cpu"),
        "hierarchy": partial(LlakeyConfig, device="cpu"),
        "environment": LlakeySimConfig,
    }
    kinds[kind](**{name: value})


def _environment(name: str, value: Any, _: Path) -> None:
    from lerobot_llakey.sim.env import LlakeySimEnv

    LlakeySimEnv(**({"task": "open_drawer", "image_size": 32} | {name: value})).reset(seed=0)


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Every number of every policy's settings as NaN, minus infinity and far below zero, and more by hand."""
    from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
    from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
    from lerobot_llakey.policies.keyframe_config import KeyframePolicyConfig

    inherited = {field.name for field in fields(KeyframePolicyConfig)}
    for kind, settings in (
        ("action", LlakeyActionConfig),
        ("command", LlakeyCommandConfig),
        ("hierarchy", LlakeyConfig),
    ):
        for field in fields(settings):
            if field.name in inherited or not isinstance(field.default, int | float) or isinstance(field.default, bool):
                continue
            for value in _NUMBERS if isinstance(field.default, float) else (-1_000_000,):
                yield Case(
                    "settings", f"{kind}.{field.name}={value}", partial(_make, kind, field.name, value), (field.name,)
                )
    by_hand: dict[str, dict[str, tuple[Any, ...]]] = {
        "action": {
            "crop_size": (0.0, 1e9),
            "workspace": ([[0, math.inf], [0, 1], [0, 1]], [[1, 0], [0, 1], [0, 1]], [[0, 1]], [[0, math.nan]] * 3),
            "splat_radius": ([1000, 1000], [-1, -1]),
            "cameras": (["front", "front"], []),
            "views": (["top", "top"], ["top"], ["up"]),
            "widths": ([], [0, 0, 0], [-1, -1, -1]),
            "dtype": ("float16", "", None),
        },
        "command": {
            "max_new_tokens": (0, -5),
            "instructions": (["pick up the block"], [7], ["grasp"]),
            "cameras": (["front", "front"],),
            "image_size": (0, -8, 33),
            "dtype": ("float8",),
            "backend": ("telepathy",),
        },
        "hierarchy": {
            "commander": ("me",),
            "fallback_instruction": ("", "dance"),
            "random_move_probability": (1.5,),
        },
        "environment": {
            "task": ("", "no_such", "open_drawer,open_drawer", None),
            "fps": (0, -1),
            "image_size": (0, -1, 10**6),
            "episode_length": (0, -3),
            "render_size": ((0, 0), (-1, 4), (10**6, 10**6)),
            "split": ("trial", ""),
            "disturbance": ("earthquake",),
            "max_parallel_tasks": (2,),
        },
    }
    for kind, chosen in by_hand.items():
        for name, values in chosen.items():
            for value in values:
                yield Case("settings", f"{kind}.{name}={value}", partial(_make, kind, name, value), (name, str(value)))
    for name, values in {
        "task": ("no_such", "", 7),
        "split": ("trial",),
        "image_size": (0, -1, 10**6, 1.5),
        "episode_length": (0, -1),
        "render_size": ((0, 0), (10**6, 10**6)),
        "render_fps": (0, -1),
        "disturbance": ("earthquake",),
    }.items():
        for value in values:
            act = partial(_environment, name, value)
            yield Case("settings", f"LlakeySimEnv({name}={value!r})", act, (name.removeprefix("render_"), str(value)))
