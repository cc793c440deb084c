"""What the options of the verbs may be: a rule for each name, the same for every verb that has it.

A verb's options are held against these rules before any work is done, right after they are read.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import torch

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count, require_number
from lerobot_llakey.errors import FileInTheWayError, LlakeyError
from lerobot_llakey.files import check_writable
from lerobot_llakey.parallel import ENGINES
from lerobot_llakey.shards import Shard
from lerobot_llakey.sim.perturbations.registry import check_disturbance
from lerobot_llakey.sim.settings import MAX_STEPS
from lerobot_llakey.sim.tasks import parse_tasks

MOST_EPISODES = 1_000_000
"""Of each task: more would take years, and the list of them more memory than there is."""
MOST_WORKERS = max(64, 4 * (os.cpu_count() or 1))
_MOST_SCENES = min(map(len, schema.SEED_RANGES.values()))
_FREE_BYTES = 10_000_000
"""That there must be where results are written: tables and plots; videos take more."""


def check_options(config: Any) -> None:
    """Hold a verb's options against the rules for their names.

    Args:
        config: a dataclass; an option that is None was not given.

    Raises:
        LlakeyError: for the first that makes no sense, or names a place that cannot be written to.
    """
    given = {part.name: getattr(config, part.name) for part in fields(config)}
    for name, value in given.items():
        if value is not None and name in RULES and not isinstance(value, bool):  # compose's split is a switch
            RULES[name](f"--{name}", value)
    if "split" in given:
        first = given.get("first_seed") or given.get("seed") or 0
        episodes = (given.get("num_episodes") or 1) * (given.get("repeats") or 1)
        last = first + episodes - 1
        if last >= _MOST_SCENES:
            raise LlakeyError(
                f"Expected scenes below {_MOST_SCENES}, got {first} to {last}; ask for fewer episodes or an earlier "
                "first one."
            )


def _split(name: str, value: str) -> None:
    if value not in schema.SEED_RANGES:
        raise LlakeyError(f"Expected {name} out of {', '.join(schema.SEED_RANGES)}, got {value!r}; pick one of these.")


def _engine(name: str, value: str) -> None:
    if value not in ENGINES:
        raise LlakeyError(f"Expected {name} out of {', '.join(ENGINES)}, got {value!r}; pick one of these.")


def _shard(name: str, value: str) -> None:
    Shard.parse(value)


def _task(name: str, value: str) -> None:
    parse_tasks(value)


def _disturbance(name: str, value: str) -> None:
    for event in value.split(","):
        check_disturbance(event.strip())


def _device(name: str, value: str) -> None:
    try:
        torch.empty(0, device=value)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        said = str(error).partition("\n")[0].rstrip(".")[:120]
        raise LlakeyError(
            f"Expected {name} to be a device of this machine such as cpu, got {value!r} ({said}); correct it."
        ) from error


def _folder(name: str, value: Path) -> None:
    check_writable(value, _FREE_BYTES)


def _file(name: str, value: Path, suffix: str) -> None:
    if value.suffix != suffix:
        raise LlakeyError(f"Expected {name} to be a file whose name ends with {suffix}, got {value}; name it so.")
    if value.is_dir():
        raise FileInTheWayError(f"Expected {name} to be a file, got the folder {value}; name a file in it.")
    check_writable(value.parent, _FREE_BYTES)


_count, _positive = require_count, partial(require_count, low=1)
_scene = partial(require_count, high=_MOST_SCENES - 1)

RULES: dict[str, Callable[[str, Any], None]] = {
    "abilities_samples": _positive,
    "actions": partial(require_count, high=MAX_STEPS),
    "batch_size": partial(require_count, low=1, high=1_000_000),
    "device": _device,
    "disturbance": _disturbance,
    "engine": _engine,
    "episode": _count,
    "first_seed": _scene,
    "html": partial(_file, suffix=".html"),
    "index": _count,
    "max_samples": _positive,
    "max_steps": partial(require_count, low=1, high=1_000_000),
    "num_actions": partial(require_count, low=1, high=MAX_STEPS * MOST_EPISODES),
    "num_demos": partial(require_count, high=MOST_EPISODES),
    "num_episodes": partial(require_count, low=1, high=MOST_EPISODES),
    "num_samples": _count,
    "samples": partial(require_count, low=1),
    "num_videos": _count,
    "num_workers": partial(require_count, high=MOST_WORKERS),
    "output": partial(_file, suffix=".png"),
    "output_dir": _folder,
    "pause_seconds": partial(require_number, low=0.0, high=3600.0),
    "port": partial(require_count, high=65535),
    "repeats": partial(require_count, low=1, high=1000),
    "rerun": partial(_file, suffix=".rrd"),
    "seed": _scene,
    "shard": _shard,
    "side_by_side": partial(require_count, low=1, high=MOST_WORKERS),
    "split": _split,
    "steps": partial(require_count, low=1, high=MOST_EPISODES),
    "task": _task,
}
"""By an option's name, what refuses a value; the paths that are read have checks of their own where they are read."""
