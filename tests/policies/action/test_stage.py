import pytest
import torch

from fakes_action import small_config
from lerobot_llakey.policies.action.stage import Stage
from lerobot_llakey.policies.action.views.scene import Scene

PUBLISHED = {"view_size": 44, "patch_size": 11, "token_width": 32, "transformer_layers": 2}


def make_scene(points: list[list[float]], text_width: int = 32) -> Scene:
    count = len(points)
    return Scene(
        points=torch.tensor(points),
        colours=torch.linspace(0.2, 0.9, 3 * count).view(count, 3),
        rows=torch.zeros(count, dtype=torch.int64),
        base=torch.zeros(1, 3),
        effector=torch.full((1, 3), 0.5),
        condition=torch.randn(1, 16, generator=torch.Generator().manual_seed(0)),
        words=torch.randn(1, 4, text_width, generator=torch.Generator().manual_seed(1)),
        padding=torch.zeros(1, 4, dtype=torch.bool),
    )


def make_stage(**settings) -> Stage:
    torch.manual_seed(0)
    return Stage(small_config(**settings), condition=16, text_width=32, splat_radius=0).eval()


@pytest.mark.parametrize(
    ("design", "size", "grid", "width"), [("small", 64, 16, 16), ("rvt", 44, 44, 64), ("rvt2", 44, 4, 128)]
)
def test_a_stage_scores_every_pixel_of_a_cube_even_if_it_is_empty(design, size, grid, width):
    stage = make_stage(design=design, **({} if design == "small" else PUBLISHED))
    output = stage(make_scene([[0.9, 0.9, 0.9]]), torch.full((1, 3), 0.1), 0.2)
    assert output.heatmap.shape == (1, 3, size, size)
    assert output.features.shape == (1, 3, grid, grid, width)
    assert output.heatmap.isfinite().all()
    assert stage.network.feature_width == width
    assert output.summary.shape == (1, stage.network.summary_width)


def test_only_our_own_design_matches_colours():
    assert make_stage().grounding is not None
    assert make_stage(design="rvt2", **PUBLISHED).grounding is None


@pytest.mark.parametrize("design", ["rvt", "rvt2"])
def test_a_crop_of_a_published_design_looks_the_same_wherever_it_lies(design):
    stage = make_stage(design=design, **PUBLISHED)
    points = torch.rand(200, 3, generator=torch.Generator().manual_seed(2)) * 0.125 + 0.25
    low, shift = torch.full((1, 3), 0.25), torch.tensor([0.25, -0.125, 0.5])  # exact in binary
    points = (points * 2**12).round() / 2**12
    still = stage(make_scene(points.tolist()), low, 0.125)
    moved = stage(make_scene((points + shift).tolist()), low + shift, 0.125)
    stayed = stage(make_scene((points + shift / 8).tolist()), low, 0.125)
    assert torch.equal(still.heatmap, moved.heatmap)
    assert torch.equal(still.features, moved.features)
    assert not torch.allclose(still.heatmap, stayed.heatmap, atol=1e-3)
