"""Makes one checkpoint out of a trained command policy and a trained action policy, and two out of one again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from huggingface_hub.constants import SAFETENSORS_SINGLE_FILE
from safetensors import safe_open
from safetensors.torch import save_file

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.processor_llakey_action import make_llakey_action_pre_post_processors
from lerobot_llakey.policies.command.processor_llakey_command import make_llakey_command_pre_post_processors
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.policies.hierarchy.processor_llakey import make_llakey_pre_post_processors


def compose(
    command_path: str | Path, action_path: str | Path, output_dir: str | Path, half: bool = False, **settings: Any
) -> LlakeyPolicy:
    """Save a checkpoint that holds both parts and stands alone: ``--policy.path=output_dir`` loads it.

    Args:
        command_path: Hub name or folder of the command policy.
        action_path: Hub name or folder of the action policy.
        output_dir: folder to write.
        half: store weights in float16, at half the size; they are loaded into float32 again.
        **settings: other fields of :class:`LlakeyConfig`, such as ``repeat_threshold``.

    Returns:
        The policy, ready to act.

    Raises:
        MissingFileError: if a path holds no checkpoint.
        LlakeyError: if one is a checkpoint of another kind.
    """
    config = LlakeyConfig(command_path=str(command_path), action_path=str(action_path), **settings)
    policy = LlakeyPolicy(config).eval()
    # Where a part was trained from is a folder of the machine that trained it.
    for part in (config.command, config.action):
        if part is not None:
            part.pretrained_path = None
    save(policy, output_dir, half)
    return policy


def split(policy_path: str | Path, output_dir: str | Path, half: bool = False) -> tuple[Path, Path]:
    """The way back: save the two parts of a checkpoint, each as a checkpoint of its own.

    Composed again they give the same weights to the last bit, and so do parts that were composed and split.

    Args:
        policy_path: Hub name or folder of a ``llakey`` checkpoint.
        output_dir: folder to write ``command`` and ``action`` into.
        half: store weights in float16.

    Returns:
        The two folders.

    Raises:
        MissingFileError: if the path holds no checkpoint.
        LlakeyError: if it is of another kind, or has no command policy.
    """
    policy = LlakeyPolicy.from_pretrained(policy_path)
    if policy.command is None:
        raise LlakeyError(
            f"Expected a checkpoint with a command policy at {policy_path}, got one whose commander is "
            f"{policy.config.commander!r}; it holds an action policy alone."
        )
    folders = Path(output_dir) / "command", Path(output_dir) / "action"
    policy.command.save_pretrained(folders[0])
    policy.action.save_pretrained(folders[1])
    processors = (
        make_llakey_command_pre_post_processors(policy.command.config),
        make_llakey_action_pre_post_processors(policy.action.config),
    )
    for folder, pipelines in zip(folders, processors, strict=True):
        if half:
            _halve(folder / SAFETENSORS_SINGLE_FILE)
        for pipeline in pipelines:
            pipeline.save_pretrained(folder)
    return folders


def save(policy: LlakeyPolicy, output_dir: str | Path, half: bool = False) -> None:
    """Write a policy together with its processors, as a training run of LeRobot does.

    Args:
        policy: what to write.
        output_dir: folder to write.
        half: store floating-point weights in float16.
    """
    policy.save_pretrained(output_dir)
    if half:
        _halve(Path(output_dir) / SAFETENSORS_SINGLE_FILE)
    for pipeline in make_llakey_pre_post_processors(policy.config):
        pipeline.save_pretrained(output_dir)


def _halve(path: Path) -> None:
    """Store the floating-point weights of a safetensors file in float16."""
    with safe_open(path, framework="pt") as file:
        metadata = file.metadata()
        weights = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    weights = {name: value.half() if torch.is_floating_point(value) else value for name, value in weights.items()}
    save_file(weights, path, metadata=metadata)
