"""``llakey determinism`` fails where two digests differ."""

import pytest

from lerobot_llakey.cli import determinism as verb
from lerobot_llakey.cli.determinism import DeterminismConfig, run
from lerobot_llakey.diagnostics.determinism import WAYS


def test_a_difference_is_the_exit_status(monkeypatch: pytest.MonkeyPatch) -> None:
    digests = dict.fromkeys(WAYS, "0123456789")
    monkeypatch.setattr(verb, "determinism", lambda *_: {"move_block": digests})
    run(DeterminismConfig("move_block"))
    digests["another process"] = "9876543210"
    with pytest.raises(SystemExit) as stop:
        run(DeterminismConfig("move_block"))
    assert stop.value.code == 1
