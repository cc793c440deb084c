"""What an environment can be asked for, held against sense before a scene is built."""

from __future__ import annotations

from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count
from lerobot_llakey.errors import LlakeyError

MAX_STEPS = 25
"""Keyframe actions after which an episode ends (paper, section IV-B)."""
_SMALLEST, _LARGEST = 16, 4096
"""Pixels of an edge; larger ones are beyond what every OpenGL driver draws."""
_HIGHEST_FPS = 1000


def check_settings(
    prefix: str,
    task: Any,
    split: Any,
    image_size: Any,
    episode_length: Any,
    oracle_instructions: Any,
    render_size: Any,
    fps: Any,
    detailed: Any,
    disturbance: Any,
) -> None:
    """Refuse settings that make no sense.

    Args:
        prefix: what a person writes before a setting's name, "env." on a command line.
        task: as all that follow, an argument of :class:`lerobot_llakey.sim.env.LlakeySimEnv` (fps: ``render_fps``);
            several tasks may be given.
        split: see there.
        image_size: see there.
        episode_length: see there.
        oracle_instructions: see there.
        render_size: see there.
        fps: see there.
        detailed: see there.
        disturbance: see there.

    Raises:
        LlakeyError: if one is of another kind, unknown or out of range.
    """
    for name, value in (("task", task), ("split", split), ("disturbance", disturbance)):
        if not isinstance(value, str):
            raise LlakeyError(f"Expected {prefix}{name} to be a text, got {value!r}; correct it.")
    for name, value in (("oracle_instructions", oracle_instructions), ("detailed", detailed)):
        if not isinstance(value, bool):
            raise LlakeyError(f"Expected {prefix}{name} to be true or false, got {value!r}; correct it.")
    schema.scene_seed(split, 0)
    require_count(f"{prefix}image_size", image_size, _SMALLEST, _LARGEST)
    require_count(f"{prefix}episode_length", episode_length, 1)
    require_count(f"{prefix}fps", fps, 1, _HIGHEST_FPS)
    if not isinstance(render_size, tuple | list) or len(render_size) != 2:
        raise LlakeyError(f"Expected {prefix}render_size to be a height and a width, got {render_size!r}; correct it.")
    for name, edge in zip(("height", "width"), render_size, strict=True):
        require_count(f"the {name} in {prefix}render_size", edge, _SMALLEST, _LARGEST)
    if task.strip() != "all" or disturbance:
        # MuJoCo is needed from here on only, so that the settings load without it.
        from lerobot_llakey.sim.perturbations.registry import check_disturbance
        from lerobot_llakey.sim.tasks import parse_tasks

        parse_tasks(task)
        check_disturbance(disturbance)
