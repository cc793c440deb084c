"""What the settings of all three policies share: one observation in, one keyframe out."""

from __future__ import annotations

from dataclasses import dataclass

from lerobot.configs import PreTrainedConfig

from lerobot_llakey.bounds import COUNT, SHARE, Bounds, require_settings
from lerobot_llakey.policies.schedule import WarmupStableDecayConfig

_BOUNDS = {
    "n_obs_steps": Bounds(1, 1, whole=True),
    "scheduler_warmup_steps": COUNT,
    "scheduler_decay_share": SHARE,
}


@dataclass
class KeyframePolicyConfig(PreTrainedConfig):
    """Base of the settings of policies that look at the present frame alone and decide on the next keyframe.

    Attributes:
        scheduler_warmup_steps: steps over which the learning rate rises.
        scheduler_decay_share: share of the training's steps over which it falls to zero at the end.
    """

    scheduler_warmup_steps: int = 200
    scheduler_decay_share: float = 0.25

    def __post_init__(self) -> None:
        super().__post_init__()
        require_settings(self, _BOUNDS)

    def get_scheduler_preset(self) -> WarmupStableDecayConfig:
        return WarmupStableDecayConfig(self.scheduler_warmup_steps, self.scheduler_decay_share)

    @property
    def observation_delta_indices(self) -> None:
        return None

    @property
    def action_delta_indices(self) -> None:
        return None

    @property
    def reward_delta_indices(self) -> None:
        return None
