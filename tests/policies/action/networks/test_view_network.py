"""What every design's network promises: heatmaps at the views' own size, and features as wide as it says."""

import pytest
import torch
from torch import Tensor

from fakes_action import small_config
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.designs import DESIGNS
from lerobot_llakey.policies.action.networks.view_network import ViewNetwork
from lerobot_llakey.policies.action.views.pixels import GROUNDED_CHANNELS, PLAIN_CHANNELS

ROWS, SIZE, CONDITION, WORDS = 2, 32, 6, 8
EVERY_DESIGN = pytest.mark.parametrize("design", DESIGNS)


def network_of(design: str) -> tuple[LlakeyActionConfig, ViewNetwork]:
    torch.manual_seed(0)
    config = small_config(design=design, view_size=SIZE, patch_size=8, token_width=16)
    return config, DESIGNS[design].build(config, CONDITION, WORDS)


def inputs_of(config: LlakeyActionConfig) -> list[Tensor | None]:
    """Pixels, matches, condition, words and padding, as a stage gives them; the last word of each row is padding."""
    grounded = DESIGNS[config.design].grounded
    grid = (ROWS, len(config.views), SIZE, SIZE)
    padding = torch.tensor([[False, False, True]] * ROWS)
    return [
        torch.randn(*grid, GROUNDED_CHANNELS if grounded else PLAIN_CHANNELS),
        torch.randn(*grid, config.colour_queries) if grounded else None,
        torch.randn(ROWS, CONDITION),
        torch.randn(ROWS, 3, WORDS),
        padding,
    ]


@EVERY_DESIGN
@pytest.mark.parametrize("bfloat16", [False, True], ids=["float32", "bfloat16"])
def test_outputs_are_as_wide_as_the_network_says(design: str, bfloat16: bool) -> None:
    config, network = network_of(design)
    with torch.autocast("cpu", dtype=torch.bfloat16, enabled=bfloat16):
        output = network(*inputs_of(config))
    assert output.heatmap.shape == (ROWS, len(config.views), SIZE, SIZE)
    assert output.heatmap.dtype == torch.float32, "the softmax over pixels needs it, whatever the network computes in"
    assert output.features.shape[:2] == output.heatmap.shape[:2]
    assert output.features.shape[2] == output.features.shape[3]
    assert output.features.shape[-1] == network.feature_width
    assert output.summary.shape == (ROWS, network.summary_width)


@EVERY_DESIGN
def test_rows_are_seen_apart_and_padding_is_not_read(design: str) -> None:
    config, network = network_of(design)
    network.eval()
    inputs = inputs_of(config)
    before = network(*inputs)
    images, words = inputs[0], inputs[3]
    assert images is not None and words is not None
    words[:, 2] = 30.0
    images[1] += 1.0
    after = network(*inputs)
    for name in ("heatmap", "features", "summary"):
        assert torch.allclose(getattr(before, name)[0], getattr(after, name)[0], atol=1e-5), name
        assert not torch.allclose(getattr(before, name)[1], getattr(after, name)[1], atol=1e-3), name


def test_a_network_without_a_forward_is_no_design() -> None:
    with pytest.raises(NotImplementedError):
        ViewNetwork()(torch.zeros(1), None, torch.zeros(1), torch.zeros(1), torch.zeros(1))
