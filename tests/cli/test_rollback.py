"""The verb counts recoveries from an event, records one, and does nothing twice."""

import json
from pathlib import Path

import pytest

from fakes_protocol import small_env
from lerobot_llakey import parallel
from lerobot_llakey.cli.rollback import RollbackConfig, run
from lerobot_llakey.evaluation.protocol import work


def test_the_expert_recovers_from_an_empty_grasp(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(parallel, "_kept", {})
    monkeypatch.setattr(work, "LlakeySimEnv", small_env)
    config = RollbackConfig(
        rows="expert", task="open_drawer", disturbance="empty_grasp", num_episodes=1, num_workers=1, output_dir=tmp_path
    )
    run(config)
    assert "1/1 (100 %)" in capsys.readouterr().out
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["rows"]["expert"]["empty_grasp"]["all"]["recovered"] == 1
    video = tmp_path / "videos" / "expert" / "open_drawer_empty_grasp_0_00_success.mp4"
    assert video.stat().st_size > 1000 and (tmp_path / "rollback.png").exists()
    made = video.stat().st_mtime_ns, (tmp_path / "episodes.jsonl").read_bytes()
    run(config)
    assert made == (video.stat().st_mtime_ns, (tmp_path / "episodes.jsonl").read_bytes())


def test_no_event_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one event"):
        run(RollbackConfig(rows="expert", disturbance=" , "))
