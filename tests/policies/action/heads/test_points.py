import torch

from lerobot_llakey.policies.action.heads.points import features_at, heatmap_weighted, locate, with_prior
from lerobot_llakey.policies.action.heads.targets import heatmap_target
from lerobot_llakey.policies.action.networks.view_network import ViewOutput
from lerobot_llakey.policies.action.views.renderer import project

VIEWS = ("top", "front", "side")


def test_points_are_found_back_from_their_heat_maps_to_a_fraction_of_a_pixel():
    points = torch.rand(20, 3, generator=torch.Generator().manual_seed(0)) * 0.8 + 0.1
    heatmap = heatmap_target(project(points, VIEWS), 40, 1.5).clamp(min=1e-12).log()
    assert (locate(heatmap, VIEWS) - points).abs().max() < 0.1 / 40


def test_the_chosen_point_is_the_best_of_all_cells():
    heatmap = torch.randn(1, 3, 9, 9, generator=torch.Generator().manual_seed(1))
    logs = heatmap.flatten(2).log_softmax(-1).view(3, 9, 9)
    score = torch.stack(
        [logs[0, x, y] + logs[1, z, y] + logs[2, z, x] for x in range(9) for y in range(9) for z in range(9)]
    )
    best = torch.stack(torch.unravel_index(score.argmax(), (9, 9, 9)))
    assert (locate(heatmap, VIEWS)[0] * 9 - 0.5 - best).abs().max() <= 0.5


def log_heat(points: torch.Tensor, size: int) -> torch.Tensor:
    return heatmap_target(project(points, VIEWS), size, 1.5).clamp(min=1e-12).log()


def test_a_zoomed_stage_that_knows_nothing_leaves_the_place_to_the_first():
    point, low, extent = torch.tensor([[0.43, 0.61, 0.52]]), torch.tensor([[0.38, 0.52, 0.4]]), 0.2
    heatmap = with_prior(torch.zeros(1, 3, 40, 40), log_heat(point, 40), low, extent, VIEWS)
    assert (low + locate(heatmap, VIEWS) * extent - point).abs().max() < 0.25 / 40


def test_a_zoomed_stage_that_is_sure_decides():
    point, low, extent = torch.tensor([[0.43, 0.61, 0.52]]), torch.tensor([[0.38, 0.52, 0.4]]), 0.2
    sure = log_heat((point - low) / extent, 40)
    heatmap = with_prior(sure, log_heat(point + 0.01, 40), low, extent, VIEWS)
    assert (low + locate(heatmap, VIEWS) * extent - point).abs().max() < 0.25 * extent / 40


def test_features_are_read_at_the_projections():
    row = torch.arange(8.0)[:, None].expand(8, 8)
    column = torch.arange(8.0)[None, :].expand(8, 8)
    maps = torch.stack((row, column), dim=-1).expand(1, 3, 8, 8, 2)
    point = torch.tensor([[0.25, 0.5, 0.75]])
    expected = (project(point, VIEWS) * 8 - 0.5).flatten(1)
    assert torch.allclose(features_at(maps, point, VIEWS), expected, atol=1e-5)


def test_heat_weighted_features_are_the_hot_pixels():
    heatmap = torch.full((1, 3, 4, 4), -30.0)
    heatmap[0, 0, 1, 2] = heatmap[0, 1, 3, 0] = 30.0
    heatmap[0, 2] = 0.0  # equally warm everywhere
    features = torch.randn(1, 3, 4, 4, 5)
    pooled = heatmap_weighted(ViewOutput(heatmap, features, torch.zeros(1, 1)), torch.zeros(1, 3), VIEWS).view(3, 5)
    expected = torch.stack((features[0, 0, 1, 2], features[0, 1, 3, 0], features[0, 2].mean(dim=(0, 1))))
    assert torch.allclose(pooled, expected, atol=1e-5)


def test_the_pose_does_not_steer_the_heat_map():
    heatmap = torch.randn(1, 3, 4, 4, requires_grad=True)
    features = torch.randn(1, 3, 4, 4, 5, requires_grad=True)
    heatmap_weighted(ViewOutput(heatmap, features, torch.zeros(1, 1)), torch.zeros(1, 3), VIEWS).sum().backward()
    assert heatmap.grad is None and features.grad.any()
