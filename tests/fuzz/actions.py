"""Actions, seeds and calls that no robot should get."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.case import Case

_GOOD = np.array([0.4, 0.0, 0.3, 1, 0, 0, 0, 1, 0], dtype=np.float32)


def _env() -> Any:
    from lerobot_llakey.sim.env import LlakeySimEnv

    return LlakeySimEnv("open_drawer", image_size=32)


def _step(action: Any, _: Path) -> str | None:
    """A refusal is a sentence; a legal pose that is out of reach is a step without motion, said in the info."""
    env = _env()
    env.reset(seed=0)
    before = env.world.data.qpos.copy()
    observation, _, _, _, info = env.step(action)
    finite = all(np.isfinite(value).all() for key, value in observation.items() if isinstance(value, np.ndarray))
    still = np.abs(env.world.data.qpos - before).max() < 0.05
    return "right" if finite and still and not info["moved"] and info["failure"] else None


def _call(use: Callable[[Any], Any], _: Path) -> None:
    env = _env()
    try:
        use(env)
    finally:
        env.close()


def _after_close(env: Any) -> None:
    env.reset(seed=0)
    env.close()
    env.step(_GOOD)


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Each number of an action as what it must not be, wrong shapes, and calls in the wrong order."""
    for index in range(len(_GOOD)):
        for value in (math.nan, math.inf, -math.inf):
            action = _GOOD.copy()
            action[index] = value
            yield Case("action", f"number {index} is {value}", partial(_step, action))
    for index in range(3):
        for value in (3.0, -5.0, 1e3, 1e7, -1e8, 1e17, 3e38):
            action = _GOOD.copy()
            action[index] = value
            yield Case("action", f"position {index} is {value:g} m", partial(_step, action))
    for scale in (0.0, 1e-20, 1e155, 1e30, 100.0):
        action = _GOOD.astype(np.float64)
        action[3:7] *= scale
        yield Case("action", f"quaternion of norm {scale:g}", partial(_step, action))
    for name, action in {
        "eight numbers": _GOOD[:8],
        "ten numbers": np.append(_GOOD, 0),
        "a batch": _GOOD[None],
        "texts": ["a"] * 9,
        "nothing": None,
        "an empty array": np.zeros(0),
        "complex numbers": _GOOD.astype(complex) * 1j,
        "gripper 255": np.where(np.arange(9) == 7, 255.0, _GOOD),
        "gripper -1": np.where(np.arange(9) == 7, -1.0, _GOOD),
        "collision flag 7": np.where(np.arange(9) == 8, 7.0, _GOOD),
    }.items():
        yield Case("action", name, partial(_step, action))
    for name, use in {
        "step before reset": lambda env: env.step(_GOOD),
        "step after close": _after_close,
        "negative seed": lambda env: env.reset(seed=-1),
        "seed beyond the split": lambda env: env.reset(seed=10**12),
        "seed 0.5": lambda env: env.reset(seed=0.5),
        "variation 1.5": lambda env: env.reset(seed=0, options={"variation": 1.5}),
        "variation 99": lambda env: env.reset(seed=0, options={"variation": 99}),
        "variation -1": lambda env: env.reset(seed=0, options={"variation": -1}),
        "variation of text": lambda env: env.reset(seed=0, options={"variation": "top"}),
    }.items():
        yield Case("action", name, partial(_call, use))
