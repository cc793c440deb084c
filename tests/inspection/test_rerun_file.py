"""A recording for rerun holds the whole decision; without rerun one sentence says what to install."""

import sys
from pathlib import Path

import pytest

from fakes_trace import FakeRerun, a_trace
from lerobot_llakey.inspection.rerun_file import require_rerun, write_rerun


def test_without_rerun_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(ValueError, match=r"lerobot_policy_llakey\[viz\]"):
        require_rerun()


def test_cloud_cameras_views_and_poses_are_logged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    fake = FakeRerun()
    monkeypatch.setitem(sys.modules, "rerun", fake)
    write_rerun(a_trace(), tmp_path / "new" / "trace.rrd")
    logged = [args[0] for name, args in fake.calls if name == "log"]
    expected = {"words", "world/cloud", "world/predicted", "world/true", "cameras/wrist", "coarse/top", "fine/side"}
    assert expected <= set(logged)
    names = [name for name, _ in fake.calls]
    assert names.index("save") < names.index("log"), "the file takes what is logged after it"
    assert (tmp_path / "new").is_dir()


def test_a_real_recording_is_written(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    write_rerun(a_trace(), tmp_path / "trace.rrd")
    assert (tmp_path / "trace.rrd").stat().st_size > 1000
