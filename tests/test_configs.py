"""Every recipe in configs/ is one that lerobot-train accepts."""

from pathlib import Path

import draccus
import pytest
from lerobot.configs.train import TrainPipelineConfig

import lerobot_llakey  # noqa: F401 - registers the policies that the recipes name
from lerobot_llakey.evaluation.protocol.rows import read_rows
from lerobot_llakey.reporting.paper_results import SUCCESS

FOLDER = Path(__file__).parent.parent / "configs"
OTHERS = ("table", "accelerate_fsdp", "reproduce")
CONFIGS = sorted(path for path in FOLDER.glob("*.yaml") if not path.stem.startswith(OTHERS))


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_recipe_is_read(path: Path) -> None:
    config = draccus.parse(TrainPipelineConfig, str(path), args=[])
    assert config.policy is not None and config.policy.type.startswith("llakey")
    assert config.steps > 0 and config.policy.push_to_hub is False


def test_the_small_baseline_differs_in_what_it_is_told_alone() -> None:
    recipes = {path.stem: draccus.parse(TrainPipelineConfig, str(path), args=[]) for path in CONFIGS}
    ours, baseline = recipes["action_small"].to_dict(), recipes["action_small_baseline"].to_dict()
    assert (ours.pop("job_name"), baseline.pop("job_name")) == ("action_small", "action_small_baseline")
    policies = ours.pop("policy"), baseline.pop("policy")
    assert ours == baseline
    told = {key: (value, policies[1][key]) for key, value in policies[0].items() if value != policies[1][key]}
    assert told == {
        "condition_on": ("instruction", "task"),
        "proprioception": ("pose", "gripper"),
        "use_timestep": (False, True),
    }


def test_the_tables_rows_are_read() -> None:
    rows = read_rows(str(FOLDER / "table.yaml"))
    assert {row.paper for row in rows} - {""} <= set(SUCCESS)
    assert [row.overrides for row in rows if "oracle" in row.name] == [{"commander": "oracle"}]


def test_there_are_recipes() -> None:
    assert {path.stem for path in CONFIGS} >= {
        "action_small",
        "action_rvt",
        "action_rvt2",
        "action_rvt_baseline",
        "action_small_baseline",
        "command_small",
        "command_small_wrist",
    }
