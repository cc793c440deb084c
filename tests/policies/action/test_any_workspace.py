"""A workspace that is no cube: crops are cubes, every target lies in its own, and what is logged is in metres."""

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.networks.view_network import ViewOutput
from lerobot_llakey.policies.action.views.renderer import project

FLAT = [[0.1, 1.3], [-0.4, 0.4], [-0.02, 0.28]]
"""1.2 x 0.8 x 0.3 metres."""
LOW, HIGH = torch.tensor(FLAT).T
CROP = 0.2


def make(**settings) -> LlakeyActionPolicy:
    torch.manual_seed(0)
    return LlakeyActionPolicy(small_config(workspace=FLAT, crop_size=CROP, **settings))


def spread(batch: dict, targets: Tensor) -> dict:
    """The batch with its keyframes at other places (B, 3)."""
    return batch | {schema.ACTION: torch.cat((targets, batch[schema.ACTION][:, 3:]), dim=1)}


def test_every_crop_is_a_cube_of_its_size_with_its_target_inside() -> None:
    policy = make(augment_translation=0.0, augment_yaw=0.0, stages=2).train()
    crops: list[tuple[Tensor, float]] = []
    policy.fine.register_forward_pre_hook(lambda module, given: crops.append((given[1], given[2])))
    batch, _, _ = observation(rows=16)
    generator = torch.Generator().manual_seed(1)
    inside: list[Tensor] = []
    for step in range(20):
        targets = LOW + torch.rand(16, 3, generator=generator) * (HIGH - LOW)
        if step == 0:  # the corners, too
            corners = torch.cartesian_prod(*(torch.tensor(bounds) for bounds in FLAT))
            targets[:8] = corners.clamp(LOW + 1e-4, HIGH - 1e-4)
        policy.forward(spread(batch, targets))
        low, extent = crops[-1]
        corner, far = policy.cube.from_unit(low), policy.cube.from_unit(low + extent)
        assert torch.allclose(far - corner, torch.tensor(CROP), atol=1e-5)  # rounding of float32 at 1 m
        inside.append(((targets > corner) & (targets < far)).all(dim=1))
        assert (targets - (corner + far) / 2).abs().max() <= policy.config.crop_noise + 1e-5
    share = torch.cat(inside).float().mean().item()
    assert len(crops) == 20 and share == 1.0


@pytest.mark.parametrize("axis", range(3))
def test_what_is_right_is_counted_in_metres_along_every_axis(axis: int) -> None:
    size = 240  # of 1.2 m: a pixel is 5 mm
    policy = make(view_size=size, stages=1).eval()
    batch, centres, _ = observation(rows=2)
    beside = torch.zeros(3)

    def hottest_beside(module: torch.nn.Module, given: tuple, output: ViewOutput) -> ViewOutput:
        places = project(policy.cube.to_unit(centres[:, 0] + beside), policy.config.views)
        rows, columns = (places * size).long().unbind(dim=-1)
        heatmap = torch.zeros_like(output.heatmap).flatten(2)
        heatmap.scatter_(2, (rows * size + columns)[..., None], 9.0)
        return replace(output, heatmap=heatmap.view_as(output.heatmap))

    policy.coarse.register_forward_hook(hottest_beside)
    shares = []
    for metres in (0.012, 0.028):
        beside[axis] = metres
        shares.append(policy.forward(batch)[1]["coarse_within_2cm"])
    assert shares == pytest.approx([1.0, 1 / 3])  # one of the three views does not show this axis
