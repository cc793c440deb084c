"""``llakey expert`` prints its table and keeps its trials."""

import json
from pathlib import Path

import pytest

from lerobot_llakey.cli.expert import ExpertConfig, run


def test_recoveries_are_printed_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(ExpertConfig("open_drawer", 2, "val", "shift", tmp_path, num_workers=1))
    header, row = capsys.readouterr().out.splitlines()[:2]
    assert header.split()[-2:] == ["struck", "recovered"] and row.split()[0] == "open_drawer"
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["disturbance"] == "shift" and len(results["trials"]) == 2


def test_no_episodes_are_refused() -> None:
    with pytest.raises(ValueError, match="--num_episodes to be a whole number from 1"):
        run(ExpertConfig(num_episodes=0))
