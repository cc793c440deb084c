"""The steps that a checkpoint's processors name.

LeRobot 0.6.1 builds whatever a step's ``class`` names before it looks whether that is a step at all: the class
``subprocess.Popen`` runs a program. So the files are read here first.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from lerobot.processor import ProcessorStepRegistry

from lerobot_llakey.errors import LlakeyError

OUR_STEPS = frozenset(
    {
        "rename_observations_processor",
        "to_batch_processor",
        "device_processor",
        "normalizer_processor",
        "unnormalizer_processor",
    }
)
"""What the processors of this package's policies are made of."""


def check_steps(file: Path, content: dict[str, Any], allowed: Collection[str] | None = None) -> None:
    """Refuse a processor that names anything but known steps and state beside it.

    Args:
        file: where it stands.
        content: what it holds.
        allowed: names of steps; None takes any that is registered with LeRobot.

    Raises:
        LlakeyError: naming the file and the step.
    """
    known = ProcessorStepRegistry.list() if allowed is None else allowed
    steps = content.get("steps")
    if not isinstance(steps, list) or not all(isinstance(step, dict) for step in steps):
        raise LlakeyError(f"Expected a list of processor steps in {file}, got {_short(steps)}; fetch or make it anew.")
    for step in steps:
        name = step.get("registry_name")
        if "class" in step or not isinstance(name, str) or name not in known:
            raise LlakeyError(
                f"Expected processor steps out of {', '.join(sorted(known))} in {file}, got "
                f"{_short(step.get('class', name))}, which could run anything; do not use this checkpoint, or make "
                "its processors anew."
            )
        if not isinstance(step.get("config", {}), dict):
            raise LlakeyError(f"Expected settings of the step {name} in {file}, got {_short(step['config'])}.")
        state = step.get("state_file")
        if state is not None and not _beside(file, state):
            raise LlakeyError(
                f"Expected the state of the step {name} in a file beside {file}, got {_short(state)}; do not use this "
                "checkpoint, or make its processors anew."
            )


def _beside(file: Path, state: Any) -> bool:
    return isinstance(state, str) and Path(state).name == state and state.endswith(".safetensors")


def _short(value: Any) -> str:
    return repr(value)[:80]
