"""``llakey keyframe-rules`` prints its table and keeps its scores."""

import json
from pathlib import Path

import pytest

from lerobot_llakey.cli.keyframe_rules import KeyframeRulesConfig, run


def test_scores_are_printed_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(KeyframeRulesConfig("open_drawer", 1, ["waypoints"], [], "train", 5000, tmp_path, num_workers=1))
    assert "waypoints" in capsys.readouterr().out.splitlines()[2]
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["split"] == "train" and len(results["recordings"]) == 1
    assert results["rules"]["waypoints"]["episodes"] == 1


@pytest.mark.parametrize("rules", [[], ["corners"]])
def test_rules_that_there_are_not_are_refused(rules: list[str]) -> None:
    with pytest.raises(ValueError, match="Expected"):
        run(KeyframeRulesConfig("open_drawer", 1, rules, [], num_workers=1))
