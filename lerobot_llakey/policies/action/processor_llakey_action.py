"""Pre- and post-processing of the action policy: LeRobot's defaults, without normalisation."""

from __future__ import annotations

from typing import Any

import torch
from lerobot.processor import PolicyAction, PolicyProcessorPipeline, make_default_pre_post_processors

from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig


def make_llakey_action_pre_post_processors(
    config: LlakeyActionConfig, dataset_stats: dict[str, dict[str, torch.Tensor]] | None = None
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]], PolicyProcessorPipeline[PolicyAction, PolicyAction]
]:
    """The pipelines around the policy, found by LeRobot's factory through their name.

    Positions, depth and colours mean what they say in the data contract, so nothing is normalised.
    """
    return make_default_pre_post_processors(config, dataset_stats, normalizer_device=config.device)
