"""The report of a check is one file with counts, findings and pictures of the first bad frames."""

import re
from pathlib import Path

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.checks.finding import Finding, Place
from lerobot_llakey.inspection.check_report import check_report


def test_counts_findings_and_pictures(tmp_path: Path) -> None:
    root = fake_keysteps(tmp_path / "sound", image_size=16).root
    dataset = LeRobotDataset("local/x", root=root)
    found = [
        Finding(schema.STATE, "finite numbers", "<nan>", "drop it", Place("episode 1, frame 2", 1, 2)),
        Finding(schema.depth_key("wrist"), "depth in millimetres", "metres", "convert it", certain=False),
    ]
    page = check_report(dataset, found, "mine & yours")
    assert "1 refused, 1 warnings" in page and "mine &amp; yours" in page and "&lt;nan&gt;" in page
    assert "episode 1, frame 2" in page
    assert page.count("data:image/png;base64,") == len(schema.CAMERAS) + 2  # all colours; colour and depth of one
    assert not re.search(r'(src|href)="(?!data:)', page)
    assert "2 instructions" in page or "instructions</h2>" in page
