import math

import pytest
import torch

from lerobot_llakey.policies.action.heads import PoseHead, features_at, locate, shift_bins
from lerobot_llakey.policies.action.renderer import project
from lerobot_llakey.policies.action.targets import heat_target

VIEWS = ("top", "front", "side")


def test_points_are_found_back_from_their_heat_maps_to_a_fraction_of_a_pixel():
    points = torch.rand(20, 3, generator=torch.Generator().manual_seed(0)) * 0.8 + 0.1
    heat = heat_target(project(points, VIEWS), 40, 1.5).clamp(min=1e-12).log()
    assert (locate(heat, VIEWS) - points).abs().max() < 0.1 / 40


def test_the_chosen_point_is_the_best_of_all_cells():
    heat = torch.randn(1, 3, 9, 9, generator=torch.Generator().manual_seed(1))
    logs = heat.flatten(2).log_softmax(-1).view(3, 9, 9)
    score = torch.stack(
        [logs[0, x, y] + logs[1, z, y] + logs[2, z, x] for x in range(9) for y in range(9) for z in range(9)]
    )
    best = torch.stack(torch.unravel_index(score.argmax(), (9, 9, 9)))
    assert (locate(heat, VIEWS)[0] * 9 - 0.5 - best).abs().max() <= 0.5


def test_features_are_read_at_the_projections():
    row = torch.arange(8.0)[:, None].expand(8, 8)
    column = torch.arange(8.0)[None, :].expand(8, 8)
    maps = torch.stack((row, column), dim=-1).expand(1, 3, 8, 8, 2)
    point = torch.tensor([[0.25, 0.5, 0.75]])
    expected = (project(point, VIEWS) * 8 - 0.5).flatten(1)
    assert torch.allclose(features_at(maps, point, VIEWS), expected, atol=1e-5)


@pytest.mark.parametrize(("present", "expected"), [(0, 3), (10, 13), (70, 1), (-5, 70)])
def test_relative_votes_turn_with_the_present_angle(present, expected):
    relative = torch.zeros(1, 72)
    relative[0, 3] = 1.0
    shifted = shift_bins(relative, torch.tensor([math.radians(5.0 * present + 0.01)]))
    assert shifted.argmax().item() == expected
    assert shifted.sum().item() == pytest.approx(1.0, abs=1e-5)


def test_relative_votes_between_bins_are_shared():
    relative = torch.zeros(1, 72)
    relative[0, 0] = 1.0
    shifted = shift_bins(relative, torch.tensor([math.radians(11.0)]))[0]
    assert shifted[2].item() == pytest.approx(0.8, abs=1e-3)
    assert shifted[3].item() == pytest.approx(0.2, abs=1e-3)


def test_votes_turn_with_the_hand_and_with_the_base():
    head = PoseHead(4, 72, 8)
    votes = torch.zeros(3, 3, 72)
    votes[1, 1, 4], votes[2, 0, 7] = 5.0, 5.0  # the second angle from the hand, the first from the base
    torch.nn.init.zeros_(head.votes.weight)
    head.votes.bias.data = votes.flatten()
    present = torch.deg2rad(torch.tensor([[0.0, 25.0, 0.0]]))
    angles, _, _ = head(torch.randn(1, 4), present, torch.deg2rad(torch.tensor([15.0])))
    assert angles[0, 0].argmax().item() == 10
    assert angles[0, 1].argmax().item() == 9


def test_the_pose_head_gives_logits_of_each_part():
    angles, gripper, collision = PoseHead(10, 72, 16)(torch.randn(3, 10), torch.zeros(3, 3), torch.zeros(3))
    assert angles.shape == (3, 3, 72)
    assert gripper.shape == collision.shape == (3, 2)
