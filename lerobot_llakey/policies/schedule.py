"""A learning rate that stays high until the last part of a run: ``--scheduler.type=warmup_stable_decay`` in LeRobot.

The rate rises linearly, stays, and falls linearly to zero over the last part. Unlike a cosine's, the long middle does
not depend on how long the run will be: any checkpoint before the fall can be resumed with more ``--steps``, as is
wanted where a machine is only there for some hours at a time. Source: Hu et al., "MiniCPM" (2024), section 4.
"""

from __future__ import annotations

from dataclasses import dataclass

from lerobot.optim.schedulers import LRSchedulerConfig
from torch.optim import Optimizer
from torch.optim.lr_scheduler import LambdaLR

from lerobot_llakey.errors import LlakeyError


@LRSchedulerConfig.register_subclass("warmup_stable_decay")
@dataclass
class WarmupStableDecayConfig(LRSchedulerConfig):
    """Settings of the schedule.

    Attributes:
        num_warmup_steps: steps of the linear rise.
        decay_share: share of all training steps over which the rate falls at the end, in 0..1.

    Raises:
        LlakeyError: if ``decay_share`` is not within 0..1.
    """

    num_warmup_steps: int = 100
    decay_share: float = 0.25

    def __post_init__(self) -> None:
        if not 0 <= self.decay_share <= 1:
            raise LlakeyError(f"Expected decay_share within 0..1, got {self.decay_share}; 0.25 is usual.")

    def build(self, optimizer: Optimizer, num_training_steps: int) -> LambdaLR:
        """The schedule of an optimiser over a run of so many steps."""
        decay_steps = max(1, round(num_training_steps * self.decay_share))

        def factor(step: int) -> float:
            rise = step / max(1, self.num_warmup_steps)
            fall = (num_training_steps - step) / decay_steps
            return max(0.0, min(1.0, rise, fall))

        return LambdaLR(optimizer, factor)
