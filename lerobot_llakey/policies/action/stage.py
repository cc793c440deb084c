"""One stage of the policy: render a cube of the cloud, look at it, and score its pixels."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from lerobot_llakey.policies.action.colour import ColourGrounding, colour_index
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.network import MultiViewNetwork, ViewOutput
from lerobot_llakey.policies.action.renderer import VIEWS, gather_pixels, project, splat

GEOMETRY_CHANNELS = 9
"""Red, green, blue, seen, depth in the cube, absolute depth, row and column, and the present end effector."""
MARKER_SIGMA = 0.02
"""Width of the end effector's mark, as a share of the view."""


@dataclass
class Scene:
    """What both stages look at, in coordinates of the unit cube that spans the workspace.

    Attributes:
        points: (M, 3) of all batch rows, end to end.
        colours: (M, 3) in 0..1.
        rows: (M,) int64 batch row of each point.
        base: (B, 3) where the workspace's lower corner lies once augmentation has moved the scene; else zero. Only its
            height is used: heights are told from the base, so that what is fixed there survives augmentation.
        effector: (B, 3) the present end effector, NaN where the state is not used.
        condition: (B, D) text and proprioception.
        words: (B, T, W) word vectors; padding: (B, T) bool, true where there is no word.
    """

    points: Tensor
    colours: Tensor
    rows: Tensor
    base: Tensor
    effector: Tensor
    condition: Tensor
    words: Tensor
    padding: Tensor


class Stage(nn.Module):
    """Rendering, colour grounding and network of one stage.

    Args:
        config: the policy's settings.
        condition: width of the condition vector.
        splat_radius: pixels by which points grow.
    """

    def __init__(self, config: LlakeyActionConfig, condition: int, splat_radius: int) -> None:
        super().__init__()
        self.views, self.size, self.splat_radius = tuple(config.views), config.view_size, splat_radius
        self.grounding = ColourGrounding(config.text_width, config.colour_queries)
        self.network = MultiViewNetwork(
            channels=GEOMETRY_CHANNELS,
            matches=config.colour_queries,
            views=len(self.views),
            size=self.size,
            condition=condition,
            text_width=config.text_width,
            widths=config.widths,
            blocks=config.blocks,
            layers=config.transformer_layers,
            heads=config.transformer_heads,
        )

    def forward(self, scene: Scene, low: Tensor, extent: float) -> ViewOutput:
        """Look at the cube that starts at a corner ``low`` (B, 3) and has edges of ``extent``, in workspace units."""
        device = low.device.type
        dtype = torch.get_autocast_dtype(device) if torch.is_autocast_enabled(device) else low.dtype
        with torch.autocast(device, enabled=False):
            local = (scene.points - low[scene.rows]) / extent
            index = splat(local, scene.rows, len(low), self.views, self.size, self.splat_radius)
            geometry = self.geometry(scene, index, low, extent, dtype)
        table = self.grounding(scene.words, scene.padding)  # (B, LEVELS^3, Q)
        lattice = colour_index(geometry[..., :3]).flatten(1)[..., None].expand(-1, -1, table.shape[-1])
        match = table.gather(1, lattice).unflatten(1, index.shape[1:]) * geometry[..., 3:4]
        return self.network(geometry, match, scene.condition, scene.words, scene.padding)

    def geometry(self, scene: Scene, index: Tensor, low: Tensor, extent: float, dtype: torch.dtype) -> Tensor:
        """Channels (B, V, S, S, GEOMETRY_CHANNELS) that do not depend on the words; positions are centred on zero."""
        axis = (torch.arange(self.size, device=low.device) + 0.5) / self.size
        # Beyond the view the mark fades; without a state it is NaN and shows nothing.
        effector = project((scene.effector - low) / extent, self.views)  # (B, V, 2)
        bumps = torch.exp(-0.5 * ((axis - effector[..., None]) / MARKER_SIGMA) ** 2).nan_to_num(0.0).to(dtype)
        images = low.new_empty(*index.shape, GEOMETRY_CHANNELS, dtype=dtype)
        images[..., :3] = gather_pixels(scene.colours, index)
        images[..., 3] = seen = index >= 0
        told = scene.base * scene.base.new_tensor((0.0, 0.0, 1.0)) + 0.5
        for view, name in enumerate(self.views):
            row, column, depth, _ = VIEWS[name]
            away = gather_pixels(scene.points[:, depth, None], index[:, view]).squeeze(-1)
            images[:, view, ..., 4] = ((away - low[:, depth, None, None]) / extent - 0.5) * seen[:, view]
            images[:, view, ..., 5] = (away - told[:, depth, None, None]) * seen[:, view]
            images[:, view, ..., 6] = (low[:, row, None] + axis * extent - told[:, row, None])[:, :, None]
            images[:, view, ..., 7] = (low[:, column, None] + axis * extent - told[:, column, None])[:, None, :]
        images[..., 8] = bumps[..., 0, :, None] * bumps[..., 1, None, :]
        return images
