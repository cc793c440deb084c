"""All three policies look at the present frame alone, and warm their learning rates up."""

import pytest

from lerobot_llakey import LlakeyActionConfig, LlakeyCommandConfig, LlakeyConfig
from lerobot_llakey.policies.keyframe_config import KeyframePolicyConfig


@pytest.mark.parametrize("kind", [LlakeyActionConfig, LlakeyCommandConfig, LlakeyConfig])
def test_they_share_their_rules(kind: type[KeyframePolicyConfig]) -> None:
    config = kind(device="cpu", scheduler_warmup_steps=7)
    assert config.get_scheduler_preset().num_warmup_steps == 7
    assert config.observation_delta_indices is config.action_delta_indices is config.reward_delta_indices is None
