"""What of a dataset trains the command policy."""

from __future__ import annotations

from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import Needs
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


def dataset_needs(config: LlakeyCommandConfig) -> Needs:
    """The columns that these settings read: words, and numbers of the robot where they are told or trained with."""
    columns = {schema.TASK, schema.SAMPLE_WEIGHT}
    columns |= {schema.INSTRUCTION} if config.target == "instruction" else {schema.ACTION}
    columns |= {schema.PREVIOUS_INSTRUCTION} if config.history else set()
    columns |= {schema.STATE} if config.uses_proprioception else set()
    if config.model is None and config.auxiliary_weight:
        columns |= {schema.STATE, schema.ACTION}
    return Needs(frozenset(columns), views=tuple(config.cameras), depth=False, workspace=None)
