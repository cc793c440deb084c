"""One stage of the policy: render a cube of the cloud and score its pixels."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.designs import DESIGNS
from lerobot_llakey.policies.action.networks.view_network import ViewOutput
from lerobot_llakey.policies.action.text.colour import ColourGrounding, colour_index
from lerobot_llakey.policies.action.views.renderer import splat
from lerobot_llakey.policies.action.views.scene import Scene


class Stage(nn.Module):
    """Rendering and network of one stage, and colour grounding where the design has it.

    Args:
        config: the policy's settings.
        condition: width of the condition vector.
        text_width: width of the word vectors.
        splat_radius: pixels by which points grow.
    """

    def __init__(self, config: LlakeyActionConfig, condition: int, text_width: int, splat_radius: int) -> None:
        super().__init__()
        design = DESIGNS[config.design]
        self.views, self.size, self.splat_radius = tuple(config.views), config.view_size, splat_radius
        self.paint = design.paint
        self.grounding: ColourGrounding | None = None
        if design.grounded:
            self.grounding = ColourGrounding(text_width, config.colour_queries)
        self.network = design.build(config, condition, text_width)

    def forward(self, scene: Scene, low: Tensor, extent: float) -> ViewOutput:
        """Score the pixels of the cube with lower corner ``low`` (B, 3) and edge ``extent``, in unit-cube units."""
        device = low.device.type
        dtype = torch.get_autocast_dtype(device) if torch.is_autocast_enabled(device) else low.dtype
        with torch.autocast(device, enabled=False):
            local = (scene.points - low[scene.rows]) / extent
            index = splat(local, scene.rows, len(low), self.views, self.size, self.splat_radius)
            images = self.paint(scene, index, low, extent, self.views, dtype)
        matches = self._match(scene, images)
        return self.network(images, matches, scene.condition, scene.words, scene.padding)

    def _match(self, scene: Scene, images: Tensor) -> Tensor | None:
        """How well the colour of each pixel (channels 0 to 2; channel 3 tells whether it is seen) fits the words."""
        if self.grounding is None:
            return None
        table = self.grounding(scene.words, scene.padding)  # (B, LEVELS^3, Q)
        lattice = colour_index(images[..., :3]).flatten(1)[..., None].expand(-1, -1, table.shape[-1])
        return table.gather(1, lattice).unflatten(1, images.shape[1:4]) * images[..., 3:4]
