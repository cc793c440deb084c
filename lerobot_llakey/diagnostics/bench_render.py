"""How fast the virtual views are rendered, against the simplest way to draw them."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.policies.action.views.renderer import VIEWS, gather_pixels, splat

POINTS = len(schema.CAMERAS) * schema.IMAGE_SIZE**2
RENDERED = ("top", "front", "side")
SIZE = 224
_WARM_UP = 3


def bench_render(steps: int, device: str) -> dict[str, Any]:
    """Render one cloud of POINTS coloured points to the RENDERED views of SIZE pixels, batch 1.

    Both renderers take turns, so that whatever else runs on the machine disturbs both.

    Args:
        steps: timed repetitions.
        device: PyTorch's device.

    Returns:
        Median and least milliseconds of :func:`renderer.splat` with colours and of :func:`draw_by_sorting`, and how
        many times faster the former is (ratio of medians, and of least times).
    """
    points, colours = _cloud(device)
    rows = torch.zeros(len(points), dtype=torch.int64, device=device)
    ways: dict[str, Callable[[], Tensor]] = {
        "renderer": lambda: gather_pixels(colours, splat(points, rows, 1, RENDERED, SIZE))[0],
        "sorting": lambda: torch.stack([draw_by_sorting(points, colours, name, SIZE) for name in RENDERED]),
    }
    times: dict[str, list[float]] = {name: [] for name in ways}
    for step in range(steps + _WARM_UP):
        for name, render in ways.items():
            start = time.perf_counter()
            render()
            if device.startswith("cuda"):
                torch.cuda.synchronize()
            if step >= _WARM_UP:
                times[name].append(1000 * (time.perf_counter() - start))
    figures: dict[str, Any] = {"device": device, "threads": torch.get_num_threads(), "points": len(points)}
    for name, values in times.items():
        figures[f"{name}_milliseconds"] = statistics.median(values)
        figures[f"{name}_least_milliseconds"] = min(values)
    for kind in ("milliseconds", "least_milliseconds"):
        figures[f"times_faster_by_{kind}"] = figures[f"sorting_{kind}"] / figures[f"renderer_{kind}"]
    return figures


def draw_by_sorting(points: Tensor, colours: Tensor, view: str, size: int) -> Tensor:
    """One view, painted from the farthest to the nearest point.

    Args:
        points: (M, 3) in the unit cube.
        colours: (M, 3).
        view: name out of :data:`renderer.VIEWS`.
        size: height and width in pixels.

    Returns:
        (size, size, 3), zero where nothing is seen.
    """
    row, column, depth, greatest = VIEWS[view]
    order = points[:, depth].argsort(descending=not greatest)
    cells = (points[order] * size).long().clamp(0, size - 1)
    image = torch.zeros(size * size, 3, device=points.device)
    image[cells[:, row] * size + cells[:, column]] = colours[order]
    return image.view(size, size, 3)


def _cloud(device: str) -> tuple[Tensor, Tensor]:
    """Points (POINTS, 3) of a table top with things on it, and colours (POINTS, 3)."""
    generator = torch.Generator().manual_seed(0)
    points, colours = torch.rand(2, POINTS, 3, generator=generator)
    points[: POINTS // 2, 2] = 0.05
    return points.to(device), colours.to(device)
