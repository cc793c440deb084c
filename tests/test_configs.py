"""Every recipe in configs/ is one that lerobot-train accepts."""

from pathlib import Path

import draccus
import pytest
from lerobot.configs.train import TrainPipelineConfig

import lerobot_llakey  # noqa: F401 - registers the policies that the recipes name

CONFIGS = sorted((Path(__file__).parent.parent / "configs").glob("*.yaml"))


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_recipe_is_read(path: Path) -> None:
    config = draccus.parse(TrainPipelineConfig, str(path), args=[])
    assert config.policy is not None and config.policy.type.startswith("llakey")
    assert config.steps > 0 and config.policy.push_to_hub is False


def test_there_are_recipes() -> None:
    assert {path.stem for path in CONFIGS} >= {
        "action_small",
        "action_rvt",
        "action_rvt2",
        "action_rvt_baseline",
        "command_small",
    }
