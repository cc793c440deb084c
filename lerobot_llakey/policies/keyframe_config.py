"""What the settings of all three policies share: one observation in, one keyframe out."""

from __future__ import annotations

from dataclasses import dataclass

from lerobot.configs import PreTrainedConfig
from lerobot.optim.schedulers import CosineAnnealingWithWarmupSchedulerConfig


@dataclass
class KeyframePolicyConfig(PreTrainedConfig):
    """Base of the settings of policies that look at the present frame alone and decide on the next keyframe.

    Attributes:
        scheduler_warmup_steps: linear warm-up of the learning rate, then cosine to zero over the training's steps.
    """

    scheduler_warmup_steps: int = 200

    def get_scheduler_preset(self) -> CosineAnnealingWithWarmupSchedulerConfig:
        return CosineAnnealingWithWarmupSchedulerConfig(num_warmup_steps=self.scheduler_warmup_steps)

    @property
    def observation_delta_indices(self) -> None:
        return None

    @property
    def action_delta_indices(self) -> None:
        return None

    @property
    def reward_delta_indices(self) -> None:
        return None
