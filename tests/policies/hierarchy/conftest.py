from pathlib import Path

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.compose import save
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

ROBOT = {"state_names": list(schema.SIM_STATE_NAMES), "workspace": [list(bounds) for bounds in schema.WORKSPACE]}
COMMAND = {
    **ROBOT,
    "cameras": ["left_shoulder", "right_shoulder", "front"],
    "image_size": 32,
    "patch_size": 16,
    "vision_width": 16,
    "vision_layers": 2,
    "vision_heads": 2,
    "text_width": 32,
    "text_layers": 1,
    "text_heads": 2,
    "dtype": "float32",
}
ACTION = {
    **ROBOT,
    "cameras": list(schema.CAMERAS),
    "view_size": 32,
    "text_width": 32,
    "text_layers": 1,
    "text_buckets": 64,
    "widths": [16, 24, 32],
    "transformer_layers": 1,
    "transformer_heads": 2,
    "dtype": "float32",
}


@pytest.fixture(scope="session")
def keysteps(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "dataset", episodes=2, image_size=32)


def tiny_config(**settings) -> LlakeyConfig:
    """Settings of a hierarchy of two tiny policies for images of 32 pixels."""
    return LlakeyConfig(
        command=LlakeyCommandConfig(device="cpu", **COMMAND),
        action=LlakeyActionConfig(device="cpu", **ACTION),
        device="cpu",
        push_to_hub=False,
        **settings,
    )


@pytest.fixture
def make_tiny(keysteps: LeRobotDataset):
    """Makes a tiny hierarchy for the fake dataset, as LeRobot's factory does."""

    def make(**settings) -> LlakeyPolicy:
        torch.manual_seed(0)
        policy = make_policy(tiny_config(**settings), ds_meta=keysteps.meta)
        assert isinstance(policy, LlakeyPolicy)
        return policy.eval()

    return make


@pytest.fixture
def training_batch(keysteps: LeRobotDataset) -> dict:
    return next(iter(torch.utils.data.DataLoader(keysteps, batch_size=6)))


@pytest.fixture
def observation(training_batch: dict) -> dict:
    """Three rows as an environment gives them: no instruction, no action."""
    hidden = (schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION, schema.ACTION)
    return {
        key: value[:3]
        for key, value in training_batch.items()
        if key not in hidden and (key.startswith("observation.") or key == schema.TASK)
    }


@pytest.fixture
def saved(make_tiny, tmp_path: Path) -> Path:
    """A saved tiny hierarchy."""
    save(make_tiny(), tmp_path / "llakey")
    return tmp_path / "llakey"
