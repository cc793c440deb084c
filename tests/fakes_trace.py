"""A made-up decision of an action policy, so that pages about decisions are tested without one."""

from __future__ import annotations

from pathlib import Path

import torch

from lerobot_llakey import geometry, schema
from lerobot_llakey.inspection.trace import StageTrace, Trace


def a_trace(views: tuple[str, ...] = ("top", "front", "side"), stages: int = 2, off: float = 0.1) -> Trace:
    """The hand is recorded at (0.5, 0, 0.2), pointing down, and predicted ``off`` metres along y from there."""
    generator = torch.Generator().manual_seed(0)
    low, edges = torch.tensor(schema.WORKSPACE).T[0], torch.ones(3)
    images, heatmap = torch.zeros(len(views), 16, 16, 3), torch.zeros(len(views), 16, 16)
    heatmap[:, 4, 4] = 1.0
    stages = [StageTrace(name, views, images, heatmap, low, edges) for name in ("coarse", "fine")[:stages]]
    tail = [*geometry.top_down(), 1.0, 0.0]
    true, predicted = torch.tensor([0.5, 0.0, 0.2, *tail]), torch.tensor([0.5, off, 0.2, *tail])
    cloud = torch.rand(500, 3, generator=generator) * torch.tensor([0.5, 0.5, 0.1])
    cameras = {name: torch.full((16, 16, 3), 0.5) for name in schema.CAMERAS}
    return Trace("open the drawer", "grasp the handle", cameras, cloud, torch.zeros(500, 3), stages, predicted, true)


class FakeRerun:
    """Stands in for the module ``rerun`` and its recordings; notes what is logged."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, tuple[object, ...]]] = []
        self.ViewCoordinates, self.RIGHT_HAND_Z_UP = self, None

    def __getattr__(self, name: str) -> object:
        def call(*args: object, **kwargs: object) -> FakeRerun:
            self.calls.append((name, args))
            if name == "save":
                Path(str(args[0])).touch()
            return self

        return call
