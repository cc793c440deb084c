"""What of a dataset trains the parts of the hierarchy, checked once for both."""

from __future__ import annotations

import functools
import operator
from typing import Any

from lerobot_llakey.checks.dataset import check_dataset
from lerobot_llakey.policies.action.dataset_needs import dataset_needs as action_needs
from lerobot_llakey.policies.command.dataset_needs import dataset_needs as command_needs
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig


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
