import pytest
import torch
from lerobot.optim.schedulers import LRSchedulerConfig

from lerobot_llakey.policies.schedule import WarmupStableDecayConfig


def rates(config: WarmupStableDecayConfig, steps: int, total: int) -> list[float]:
    optimizer = torch.optim.SGD([torch.nn.Parameter(torch.zeros(1))], lr=2.0)
    scheduler = config.build(optimizer, total)
    found = []
    for _ in range(steps):
        found.append(scheduler.get_last_lr()[0])
        optimizer.step()
        scheduler.step()
    return found


def test_rate_rises_stays_and_falls():
    found = rates(WarmupStableDecayConfig(num_warmup_steps=4, decay_share=0.25), 21, 20)
    assert found[:5] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert found[4:16] == [2.0] * 12
    assert found[15:] == pytest.approx([2.0, 1.6, 1.2, 0.8, 0.4, 0.0])


def test_before_the_fall_the_length_of_the_run_does_not_matter():
    config = WarmupStableDecayConfig(num_warmup_steps=2, decay_share=0.2)
    assert rates(config, 15, 20) == rates(config, 15, 2000)


@pytest.mark.parametrize("share", [-0.1, 1.5])
def test_a_share_outside_its_range_is_refused(share):
    with pytest.raises(ValueError, match="decay_share"):
        WarmupStableDecayConfig(decay_share=share)


def test_lerobot_knows_it_by_name():
    assert LRSchedulerConfig.get_choice_class("warmup_stable_decay") is WarmupStableDecayConfig
