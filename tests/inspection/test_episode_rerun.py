"""An episode's recording for rerun holds cloud, hands, cameras and words over time."""

import sys
from pathlib import Path

import pytest

from fakes import fake_keysteps
from fakes_trace import FakeRerun
from lerobot_llakey.inspection.episode_look import EpisodeLook
from lerobot_llakey.inspection.episode_rerun import write_episode


def test_everything_is_logged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    fake = FakeRerun()
    monkeypatch.setitem(sys.modules, "rerun", fake)
    look = EpisodeLook(fake_keysteps(tmp_path / "data", episodes=1, frames=4, cameras=("front", "wrist")), 0)
    write_episode(look, tmp_path / "new" / "episode.rrd")
    logged = [args[0] for name, args in fake.calls if name == "log"]
    for path in ("world/cloud", "world/hand", "world/next", "cameras/front", "cameras/wrist", "instruction"):
        assert logged.count(path) == 4, path
    assert logged.count("instructions") == 2 and {"world/keyframes/0", "world/keyframes/1"} <= set(logged)
    assert (tmp_path / "new" / "episode.rrd").exists()
    texts = [args[0] for name, args in fake.calls if name == "TextDocument"]
    assert look.keyframes[1].instruction in texts


def test_without_a_file_the_viewer_opens(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    fake = FakeRerun()
    monkeypatch.setitem(sys.modules, "rerun", fake)
    write_episode(EpisodeLook(fake_keysteps(tmp_path / "data", episodes=1, frames=2, cameras=("front",)), 0), None)
    names = [name for name, _ in fake.calls]
    assert "spawn" in names and "save" not in names


def test_a_real_recording_is_written(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    look = EpisodeLook(fake_keysteps(tmp_path / "data", episodes=1, frames=3, cameras=("front",)), 0)
    write_episode(look, tmp_path / "episode.rrd")
    assert (tmp_path / "episode.rrd").stat().st_size > 10_000
