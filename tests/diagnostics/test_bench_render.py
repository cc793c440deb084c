"""The benchmark's simple renderer draws what the policy's does, so that their times can be compared."""

import pytest
import torch

from lerobot_llakey.diagnostics.bench_render import POINTS, bench_render, draw_by_sorting
from lerobot_llakey.policies.action.views.renderer import VIEWS, gather_pixels, splat


@pytest.mark.parametrize("view", list(VIEWS))
def test_both_renderers_draw_the_same(view: str) -> None:
    points, colours = torch.rand(2, 500, 3, generator=torch.Generator().manual_seed(0))
    index = splat(points, torch.zeros(500, dtype=torch.int64), 1, [view], 12)
    assert torch.equal(draw_by_sorting(points, colours, view, 12), gather_pixels(colours, index)[0, 0])


def test_figures_compare_the_renderers_in_one_run() -> None:
    figures = bench_render(steps=2, device="cpu")
    assert figures["points"] == POINTS == 4 * 128 * 128
    assert figures["renderer_milliseconds"] >= figures["renderer_least_milliseconds"] > 0
    ratio = figures["sorting_milliseconds"] / figures["renderer_milliseconds"]
    assert figures["times_faster_by_milliseconds"] == pytest.approx(ratio)
