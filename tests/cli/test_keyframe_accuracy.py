"""``llakey keyframe-accuracy`` as typed."""

import json
from pathlib import Path

import pytest

from fakes import fake_keysteps
from fakes_action import small_config
from lerobot_llakey.cli.keyframe_accuracy import KeyframeAccuracyConfig, run
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.processor_llakey_action import make_llakey_action_pre_post_processors


def test_shares_by_verb_are_printed_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    policy = LlakeyActionPolicy(small_config())
    policy.save_pretrained(tmp_path / "policy")
    for pipeline in make_llakey_action_pre_post_processors(policy.config):
        pipeline.save_pretrained(tmp_path / "policy")
    root = fake_keysteps(tmp_path / "data", episodes=1, frames=4).root
    run(KeyframeAccuracyConfig(str(tmp_path / "policy"), "me/x", root, num_samples=3, output_dir=tmp_path / "out"))
    table = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    header, _, first, *_ = table
    columns = [cell.strip() for cell in header.split("|")[1:-1]]
    assert columns == ["verb", "samples", "1 cm", "2 cm", "5 deg", "10 deg", "gripper", "collision"]
    cells = [cell.strip() for cell in first.split("|")[1:-1]]
    assert cells[:2] == ["all", "3"] and all(cell.endswith(" %") for cell in cells[2:])
    figures = json.loads((tmp_path / "out" / "results.json").read_text())
    assert figures["all"]["samples"] == 3 and 0 <= figures["all"]["rotation_within_5deg"] <= 1


def test_a_missing_policy_is_told_before_the_dataset_is_looked_for(tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match="Expected a checkpoint"):
        run(KeyframeAccuracyConfig(str(tmp_path / "nothing" / "here"), "me/x", tmp_path / "nothing"))
