"""``llakey stress`` prints what it came to, and fails where the simulator did."""

import pytest

from lerobot_llakey.cli import stress as verb
from lerobot_llakey.cli.stress import StressConfig, run
from lerobot_llakey.diagnostics.stress import Stress


def test_what_went_wrong_is_the_exit_status(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = {"move_block": Stress("move_block", 25, slowest=1.5)}
    monkeypatch.setattr(verb, "stress", lambda *_: found)
    run(StressConfig("move_block", 25))
    assert "1.5 s" in capsys.readouterr().out
    found["move_block"].sunk.append(("red_block", 3))
    with pytest.raises(SystemExit) as stop:
        run(StressConfig("move_block", 25))
    assert stop.value.code == 1


def test_no_actions_are_refused() -> None:
    with pytest.raises(ValueError, match="--num_actions to be a whole number from 1"):
        run(StressConfig(num_actions=0))
