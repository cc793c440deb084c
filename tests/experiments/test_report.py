"""The report shows what is there, and its links lead somewhere."""

import re
from pathlib import Path

from lerobot_llakey.experiments.report import write_report


def test_every_part_and_every_link(tmp_path: Path) -> None:
    for name in ("table", "rollback"):
        (tmp_path / name / "videos" / "llakey").mkdir(parents=True)
        (tmp_path / name / "table.md").write_text(f"# Page of {name}\n\nfigures\n")
        (tmp_path / name / f"{name}.png").write_bytes(b"")
        (tmp_path / name / "videos" / "llakey" / "open_drawer_0_00_success.mp4").write_bytes(b"")
    text = write_report(tmp_path, "toy", [], "| stage |").read_text()
    assert "### Page of table" in text and "\n# Page" not in text
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert len(links) == 4 and all((tmp_path / link).is_file() for link in links)
    assert "Figure 1" not in text, "a part that was not made is not shown"
    assert text.rstrip().endswith("| stage |")
