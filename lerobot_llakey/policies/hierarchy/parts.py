"""The two parts of the hierarchy: loading a trained one, and what training them takes."""

from __future__ import annotations

import functools
import operator
from pathlib import Path
from typing import Any

from lerobot.configs import PreTrainedConfig
from lerobot.policies.pretrained import PreTrainedPolicy

from lerobot_llakey.checks.dataset import check_dataset
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.policies.action.dataset_needs import dataset_needs as action_needs
from lerobot_llakey.policies.command.training_dataset import dataset_needs as command_needs
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.saved.folder import inspect_checkpoint, read_settings
from lerobot_llakey.saved.own import given_options
from lerobot_llakey.saved.processors import OUR_STEPS


def load_part[P: PreTrainedPolicy](
    policy_class: type[P], path: str | Path, device: str | None, own: PreTrainedConfig | None = None
) -> P:
    """A trained part from a Hub name or a folder.

    Args:
        policy_class: what the checkpoint must hold.
        path: where it is.
        device: where its weights go.
        own: settings whose servers, variables and paths, which only the user gives, hold for the part.

    Raises:
        MissingFileError: if there is no checkpoint at ``path``.
        LlakeyError: if it is a checkpoint of another kind, broken, or names what no checkpoint may.
    """
    try:
        folder = inspect_checkpoint(path, OUR_STEPS)
    except MissingFileError as error:
        raise MissingFileError(f"{error} A checkpoint of type {policy_class.name!r} was to be loaded.") from error
    kind = read_settings(folder)["type"]
    if kind != policy_class.name:
        raise LlakeyError(
            f"Expected a checkpoint of type {policy_class.name!r} at {path}, got one of type {kind!r}: a checkpoint of "
            "another kind; give the path of the right one."
        )
    config = PreTrainedConfig.from_pretrained(folder, cli_overrides=[] if own is None else given_options(own))
    config.device = device
    return policy_class.from_pretrained(folder, config=config, strict=True)


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


def check_training_dataset(config: LlakeyConfig, meta: Any | None) -> None:
    """Refuse a dataset that cannot train the parts that are trained; nothing where there is none.

    Args:
        config: the policy's settings.
        meta: a ``LeRobotDatasetMetadata``, or None.

    Raises:
        LlakeyError: if a column is wrong, see :mod:`lerobot_llakey.checks.dataset`.
    """
    needs = []
    if config.has_command and config.train_command and config.command.backend == "local":
        needs.append(command_needs(config.command))
    if config.train_action:
        needs.append(action_needs(config.action))
    if meta is not None and needs:
        check_dataset(meta, functools.reduce(operator.or_, needs))
