"""``llakey show`` writes the page of a saved policy's decision."""

import sys
from pathlib import Path

import cv2
import pytest
import torch

from fakes import fake_keysteps
from fakes_action import small_config
from lerobot_llakey.cli import show
from lerobot_llakey.cli.main import main
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.rollout.actors import Agent


def test_the_page_is_written_and_the_errors_are_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    torch.manual_seed(0)
    agent = Agent(LlakeyActionPolicy(small_config(stages=1)).eval(), lambda batch: batch, lambda action: action)
    monkeypatch.setattr(Agent, "load", staticmethod(lambda path, **given: agent))
    monkeypatch.setattr(show, "inspect_checkpoint", lambda path: path)
    monkeypatch.setattr(sys, "argv", list(sys.argv))
    fake_keysteps(tmp_path / "data", episodes=1, frames=2)
    output = tmp_path / "pages" / "show.png"
    options = ["--policy_path=x", "--repo_id=llakey/fake", f"--root={tmp_path / 'data'}", f"--output={output}"]
    main(["show", *options, "--index=1"])
    said = capsys.readouterr().out
    assert "instruction: grasp the" in said and "off by" in said and str(output) in said
    picture = cv2.imread(str(output))
    assert picture is not None and picture.shape[1] == 4 * 240


def test_rerun_is_asked_for_before_anything_is_loaded(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    monkeypatch.setattr(sys, "argv", list(sys.argv))
    with pytest.raises(SystemExit):
        main(["show", "--policy_path=x", "--repo_id=nothing/here", "--rerun=look.rrd"])
    assert "lerobot_policy_llakey[viz]" in capsys.readouterr().err
