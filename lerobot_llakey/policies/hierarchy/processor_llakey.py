"""Pre- and post-processing of the hierarchical policy: its parts normalise for themselves, texts pass untouched."""

from __future__ import annotations

from typing import Any

from lerobot.processor import PolicyAction, PolicyProcessorPipeline, make_default_pre_post_processors
from torch import Tensor

from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig


def make_llakey_pre_post_processors(
    config: LlakeyConfig, dataset_stats: dict[str, dict[str, Tensor]] | None = None
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]], PolicyProcessorPipeline[PolicyAction, PolicyAction]
]:
    """LeRobot's standard pipelines: rename, batch, move to the device; and the way back.

    Args:
        config: of the policy; its normalisation is the identity, so metres stay metres and millimetres millimetres.
        dataset_stats: kept by the pipelines' normaliser, not used.
    """
    return make_default_pre_post_processors(config, dataset_stats, normalizer_device=config.device)
