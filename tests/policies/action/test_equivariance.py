"""Cloud, hand and target moved together: targets and predictions move with them."""

import math

import pytest
import torch
from torch import Tensor

from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.augmentation import RigidMotion
from lerobot_llakey.policies.action.batch.labels import moved, read_labels
from lerobot_llakey.policies.action.batch.point_cloud import fuse_views
from lerobot_llakey.policies.action.batch.proprioception import read_proprioception
from lerobot_llakey.policies.action.heads.points import locate
from lerobot_llakey.policies.action.heads.targets import heatmap_target
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.views.renderer import VIEWS, project, splat

MOTIONS = [(0.0, (0.06, 0.0, 0.0)), (0.0, (0.0, -0.06, 0.05)), (25.0, (0.0, 0.0, 0.0)), (-20.0, (-0.05, 0.05, 0.03))]


def motion(rows: int, pivot: Tensor, yaw: float, shift: tuple[float, float, float]) -> RigidMotion:
    return RigidMotion(torch.full((rows,), math.radians(yaw)), pivot, torch.tensor([shift] * rows))


@pytest.mark.parametrize(("yaw", "shift"), [*MOTIONS, (90.0, (0.0, 0.0, 0.0))])
def test_the_heat_target_stays_on_the_same_thing(yaw: float, shift: tuple[float, float, float]) -> None:
    # The target is put on a point of the cloud; after the motion the very pixels of that point must be the hottest.
    batch, centres, _ = observation(rows=1)
    workspace, size, views = torch.tensor(schema.WORKSPACE), 100, list(VIEWS)
    wide = torch.tensor([[-2.0, 3.0]] * 3)  # no point drops out, so that indices name the same point before and after
    still = fuse_views(batch, schema.CAMERAS, wide)
    for centre in centres[0]:
        chosen = (still.points - centre).norm(dim=1).argmin()
        batch[schema.ACTION][0, schema.POSITION] = still.points[chosen]
        labels = read_labels(batch[schema.ACTION], workspace)
        after, shifted = moved(
            batch, labels, motion(1, torch.tensor([[0.5, 0.0, 0.1]]), yaw, shift), schema.CAMERAS, range(8)
        )
        points = fuse_views(after, schema.CAMERAS, wide).points
        assert len(points) == len(still.points)
        unit = (points[chosen] - workspace[:, 0]) / (workspace[:, 1] - workspace[:, 0])
        shown = splat(unit[None], torch.zeros(1, dtype=torch.int64), 1, views, size)[0]
        target = (shifted.position[0] - workspace[:, 0]) / (workspace[:, 1] - workspace[:, 0])
        heatmap = heatmap_target(project(target, views), size, 0.7)
        for view in range(len(views)):
            hottest, drawn = (heatmap[view] == heatmap[view].max()).nonzero()[0], (shown[view] == 0).nonzero()[0]
            assert (hottest - drawn).abs().max() <= 1  # a coordinate on the edge of two pixels may fall either way


def test_a_trained_policys_prediction_moves_within_the_bin_size() -> None:
    torch.manual_seed(0)
    # What is told relative to the base stays with the base, which is not moved here.
    settings = {"rotation_frames": ["view", "hand"], "heatmap_shrink_steps": 60, "heatmap_sigma_start": 2.0}
    policy = LlakeyActionPolicy(small_config(view_size=48, augment_translation=0.1, augment_yaw=30.0, **settings))
    batch, _, _ = observation(rows=3)
    optimiser = torch.optim.AdamW(policy.get_optim_params(), lr=4e-3, betas=(0.9, 0.98))
    schedule = torch.optim.lr_scheduler.LinearLR(optimiser, 1.0, 0.05, 120)
    for _ in range(120):
        loss, _ = policy.forward(batch)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    before = policy.select_action(batch)
    labels = read_labels(batch[schema.ACTION], policy.workspace)
    pixel, rotation_bin = 1.0 / policy.config.view_size, 360 / policy.config.rotation_bins
    for yaw, shift in MOTIONS:
        change = motion(3, labels.position, yaw, shift)
        after = policy.select_action(moved(batch, labels, change, schema.CAMERAS, range(8))[0])
        expected = change.move_points(before[:, schema.POSITION])
        assert (after[:, schema.POSITION] - expected).norm(dim=1).max() < pixel
        cosine = (after[:, schema.QUATERNION] * change.move_quaternion(before[:, schema.QUATERNION])).sum(dim=1)
        assert torch.rad2deg(2 * cosine.abs().clamp(max=1.0).arccos()).max() < rotation_bin + 0.1
        if any(shift):  # and it did move, by several pixels
            assert (after[:, schema.POSITION] - before[:, schema.POSITION]).norm(dim=1).min() > 2 * pixel


def test_any_weights_find_a_moved_crop_at_the_moved_place() -> None:
    # Exact for the published designs' second stage, which is told places within its crop alone.
    torch.manual_seed(0)
    size, extent = 44, 0.125
    settings = {"design": "rvt2", "view_size": size, "patch_size": 11, "token_width": 32, "transformer_layers": 2}
    policy = LlakeyActionPolicy(small_config(**settings)).eval()
    batch, _, _ = observation(rows=1)
    cloud = fuse_views(batch, policy.config.cameras, policy.workspace)
    scene = policy._scene(
        cloud, read_proprioception(batch, policy.config, 1), [batch[schema.INSTRUCTION]], torch.zeros(1, 3)
    )
    scene.points = (scene.points * 2**12).round() / 2**12  # so that adding the shift rounds nothing
    low, shift = torch.tensor([[0.5, 0.5, 0.0]]), torch.tensor([[-0.25, 0.125, 0.5]])
    found = low + locate(policy.fine(scene, low, extent).heatmap, policy.config.views) * extent
    scene.points = scene.points + shift
    again = low + shift + locate(policy.fine(scene, low + shift, extent).heatmap, policy.config.views) * extent
    # The heatmaps are the same; adding the crop's corner and the shift rounds in another order, by some 1e-8 metres.
    assert torch.allclose(found + shift, again, rtol=0.0, atol=1e-6)
