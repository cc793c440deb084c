"""What of a dataset trains the action policy, and its check."""

from __future__ import annotations

from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import Needs, check_dataset
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig


def dataset_needs(config: LlakeyActionConfig) -> Needs:
    """The columns that these settings read, cameras with depth among them."""
    columns = {*config.required_features(), schema.ACTION, schema.SAMPLE_WEIGHT}
    columns |= {schema.TASK} if config.condition_on != "instruction" else set()
    columns |= {schema.INSTRUCTION} if config.condition_on != "task" else set()
    return Needs(frozenset(columns), cameras=tuple(config.cameras), workspace=config.box)


def check_training_dataset(config: LlakeyActionConfig, meta: Any) -> None:
    """Refuse a dataset that cannot train the policy.

    Args:
        config: the policy's settings.
        meta: a ``LeRobotDatasetMetadata``.

    Raises:
        LlakeyError: if a column is missing or wrong, see :mod:`lerobot_llakey.checks.dataset`.
    """
    config.learn_grammar(meta.features)
    config.validate_instructions(meta.features)
    check_dataset(meta, dataset_needs(config))
