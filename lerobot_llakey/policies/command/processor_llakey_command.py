"""Pre- and post-processing of the command policy: nothing is normalised here, the model does its own."""

from __future__ import annotations

from typing import Any

from lerobot.processor import PolicyAction, PolicyProcessorPipeline, make_default_pre_post_processors
from torch import Tensor

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


def make_llakey_command_pre_post_processors(
    config: LlakeyCommandConfig, dataset_stats: dict[str, dict[str, Tensor]] | None = None
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]], PolicyProcessorPipeline[PolicyAction, PolicyAction]
]:
    """LeRobot's standard pipelines: rename, batch, move to the device; and the way back."""
    return make_default_pre_post_processors(config, dataset_stats, normalizer_device=config.device)
