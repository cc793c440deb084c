"""The verb checks its options before it loads a policy, and starts the session that they ask for."""

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from lerobot_llakey.cli import drive
from lerobot_llakey.cli.drive import DriveConfig, make_session


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"task": "open_door"}, "got 'open_door'"),
        ({"split": "exam"}, "got 'exam'"),
        ({"disturbance": "storm"}, "got 'storm'"),
        ({"policy_path": "no/such/checkpoint"}, "Expected a checkpoint folder"),
    ],
)
def test_wrong_options_are_told(options: dict[str, str], message: str) -> None:
    with pytest.raises((ValueError, FileNotFoundError), match=message):
        make_session(DriveConfig(**options))


def test_terminal_without_a_value_and_a_missing_page(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, tmp_path: Path
) -> None:
    asked: list[bool] = []
    monkeypatch.setattr(drive, "make_session", lambda config: asked.append(config.terminal) or _Silent())
    monkeypatch.setattr(drive, "Terminal", lambda session: session)
    monkeypatch.setattr(sys, "argv", ["llakey drive", "--terminal", f"--output_dir={tmp_path}"])
    drive.main()
    assert asked == [True] and str(tmp_path) in capsys.readouterr().out
    monkeypatch.setitem(sys.modules, "gradio", None)  # as if it were not installed
    monkeypatch.setattr(sys, "argv", ["llakey drive"])
    with pytest.raises(SystemExit):
        drive.main()
    assert "pip install 'lerobot_policy_llakey[drive]'" in capsys.readouterr().err
    assert asked == [True]  # told before a policy is loaded


@pytest.mark.parametrize(("port", "said"), [("99999", "from 0 to 65535, got 99999"), ("-1", "got -1")])
def test_a_port_out_of_range_is_told_before_a_policy_is_loaded(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, port: str, said: str
) -> None:
    pytest.importorskip("gradio")
    monkeypatch.setattr(drive, "make_session", lambda config: pytest.fail("the policy was loaded"))
    monkeypatch.setattr(sys, "argv", ["llakey drive", f"--port={port}"])
    with pytest.raises(SystemExit):
        drive.main()
    assert said in capsys.readouterr().err


class _Silent(ModuleType):
    def __init__(self) -> None:
        super().__init__("silent")

    def talk(self) -> None:
        pass

    def close(self) -> Any:
        pass
