"""Loads one trained part of the hierarchy, and refuses anything else."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from huggingface_hub.errors import HFValidationError
from lerobot.configs import PreTrainedConfig
from lerobot.policies.pretrained import PreTrainedPolicy

from lerobot_llakey.errors import LlakeyError, MissingFileError


def load_part[P: PreTrainedPolicy](policy_class: type[P], path: str | Path, device: str | None) -> P:
    """A trained part from a Hub name or a folder.

    Args:
        policy_class: what the checkpoint must hold.
        path: where it is.
        device: where its weights go.

    Raises:
        FileNotFoundError: if there is no checkpoint at ``path``.
        ValueError: if it is a checkpoint of another kind.
    """
    try:
        config = PreTrainedConfig.from_pretrained(path)
    except (OSError, HFValidationError) as error:
        raise MissingFileError(
            f"Expected a folder or Hub name of a {policy_class.name!r} checkpoint, got {str(path)!r}, where none was "
            "found; check the path."
        ) from error
    if not isinstance(config, policy_class.config_class):
        raise LlakeyError(
            f"Expected a checkpoint of type {policy_class.name!r} at {path}, got one of type {config.type!r}: a "
            "checkpoint of another kind; give the path of the right one."
        )
    config.device = device
    try:
        return policy_class.from_pretrained(path, config=config, strict=True)
    except RuntimeError as error:
        raise LlakeyError(
            f"Expected weights that fit the settings of the {policy_class.name!r} checkpoint at {path}, got a "
            f"checkpoint of another kind ({str(error).splitlines()[0]}); save it again or give another path."
        ) from error


def check_keys(path: str | Path, missing: Iterable[str], unexpected: Iterable[str]) -> None:
    """Refuse weights that are not those of the policy.

    Raises:
        ValueError: if any are missing or unexpected.
    """
    missing, unexpected = sorted(missing), sorted(unexpected)
    if missing or unexpected:
        raise LlakeyError(
            f"Expected the weights of a llakey checkpoint in {path}, got a checkpoint of another kind: {len(missing)} "
            f"missing {missing[:2]}, {len(unexpected)} unexpected {unexpected[:2]}; give one saved by this policy."
        )


def parameter_groups(part: PreTrainedPolicy, multiplier: float) -> list[dict[str, Any]]:
    """The optimiser's groups of one part, each with the rate, betas and decay of the part's own preset.

    Args:
        part: a policy whose preset is AdamW or Muon.
        multiplier: factor on its learning rate.
    """
    preset = part.config.get_optimizer_preset()
    groups: Any = part.get_optim_params()
    if isinstance(groups, dict):
        groups = [groups] if "params" in groups else list(groups.values())
    groups = list(groups)
    if not groups or not isinstance(groups[0], dict):
        groups = [{"params": groups}]
    defaults = {"lr": preset.lr, "betas": preset.betas, "eps": preset.eps, "weight_decay": preset.weight_decay}
    groups = [defaults | group for group in groups]
    return [group | {"lr": group["lr"] * multiplier} for group in groups]
