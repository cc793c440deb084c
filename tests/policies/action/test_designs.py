"""The designs by name, and the published ones at their published size."""

from pathlib import Path

import draccus
import pytest
import torch
from lerobot.configs.train import TrainPipelineConfig

from fakes_action import small_config
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.designs import DESIGNS, make_pose_head, make_text_encoder
from lerobot_llakey.policies.action.heads.pose_heads import BinsHead
from lerobot_llakey.policies.action.heads.rotation_sequential import SequentialBinsHead
from lerobot_llakey.policies.action.heads.rotation_sixd import SixDHead
from lerobot_llakey.policies.action.limits import CHOICES
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.text.word_encoder import TextEncoder

CONFIGS = Path(__file__).parents[3] / "configs"


def recipe(name: str) -> LlakeyActionConfig:
    config = draccus.parse(TrainPipelineConfig, str(CONFIGS / f"{name}.yaml"), args=[]).policy
    assert isinstance(config, LlakeyActionConfig)
    features = small_config()
    config.state_names = features.state_names
    config.input_features, config.output_features = features.input_features, features.output_features
    return config


def millions(module: torch.nn.Module) -> float:
    return sum(parameter.numel() for parameter in module.parameters()) / 1e6


def test_the_settings_name_every_design() -> None:
    assert tuple(DESIGNS) == CHOICES["design"]


@pytest.mark.parametrize(
    ("name", "design", "stages", "published"),
    [("action_rvt", "rvt", 1, 36.3), ("action_rvt_baseline", "rvt", 1, 36.3), ("action_rvt2", "rvt2", 2, 2 * 36.6)],
)
def test_published_designs_have_their_published_size(name: str, design: str, stages: int, published: float) -> None:
    config = recipe(name)
    assert (config.design, config.stages) == (design, stages)
    with torch.device("meta"):  # counts without allocating
        policy = LlakeyActionPolicy(config)
    assert millions(policy) == pytest.approx(published, rel=0.05)
    # Nor does the text encoder make up for something missing.
    assert millions(policy) - millions(policy.text) == pytest.approx(published, rel=0.05)
    for stage in (policy.coarse, policy.fine)[:stages]:
        assert millions(stage) == pytest.approx(published / stages, rel=0.05)


def test_the_shipped_design_is_small() -> None:
    with torch.device("meta"):
        assert millions(LlakeyActionPolicy(recipe("action_small"))) < 8


def test_published_designs_look_as_published() -> None:
    rvt, rvt2, baseline = recipe("action_rvt"), recipe("action_rvt2"), recipe("action_rvt_baseline")
    assert (len(rvt.views), rvt.view_size // rvt.patch_size, rvt.rotation) == (5, 20, "bins")
    assert (len(rvt2.views), rvt2.view_size // rvt2.patch_size, rvt2.rotation) == (3, 16, "sequential_bins")
    assert (rvt.condition_on, rvt.use_timestep) == ("instruction", False)
    changed = {key for key, value in vars(rvt).items() if vars(baseline)[key] != value}
    assert changed == {"condition_on", "use_timestep"}
    assert (baseline.condition_on, baseline.use_timestep) == ("task", True)


def test_heads_and_text_encoder_follow_the_settings() -> None:
    heads = {"bins": BinsHead, "sequential_bins": SequentialBinsHead, "sixd": SixDHead}
    for rotation, kind in heads.items():
        assert type(make_pose_head(small_config(rotation=rotation), 8)) is kind
    assert isinstance(make_text_encoder(small_config()), TextEncoder)
