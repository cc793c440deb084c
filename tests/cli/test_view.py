"""``llakey view`` writes a page, a recording, or both; rerun is asked for before a dataset is fetched."""

import sys
from pathlib import Path

import pytest

from fakes import fake_keysteps
from lerobot_llakey.cli.main import main


@pytest.fixture(autouse=True)
def arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", list(sys.argv))


def test_a_page_is_written_without_rerun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    fake_keysteps(tmp_path / "data", episodes=2, frames=4)
    page = tmp_path / "pages" / "episode.html"
    main(["view", "--repo_id=llakey/fake", f"--root={tmp_path / 'data'}", "--episode=1", f"--html={page}"])
    assert f"page: {page}" in capsys.readouterr().out and "episode 1" in page.read_text()


def test_a_recording_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rerun")
    fake_keysteps(tmp_path / "data", episodes=1, frames=2)
    file = tmp_path / "episode.rrd"
    main(["view", "--repo_id=llakey/fake", f"--root={tmp_path / 'data'}", f"--rerun={file}"])
    assert file.stat().st_size > 10_000 and f"recording: {file}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--rerun=episode.rrd"], "lerobot_policy_llakey[viz]"),
        ([], "lerobot_policy_llakey[viz]"),
        (["--html=page.png"], "ends with .html"),
        (["--episode=-1", "--html=page.html"], "--episode to be a whole number of 0 or more"),
    ],
)
def test_what_cannot_be_is_said_first(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], options: list[str], said: str
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(SystemExit):
        main(["view", "--repo_id=nothing/here", *options])
    assert said in capsys.readouterr().err
