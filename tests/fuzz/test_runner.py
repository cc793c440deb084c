"""Every way in which a wrong input can end is told from the others."""

import os
import signal
import time
from pathlib import Path

import pytest

from fuzz import runner
from fuzz.case import BAD, Case
from lerobot_llakey.errors import LlakeyError


def _refuse(_: Path) -> None:
    raise LlakeyError("Expected a cup, got a glass; take a cup.")


def _refuse_on_the_command_line(_: Path) -> None:
    os.write(2, b"error: Expected a cup, got a glass; take a cup.\n")
    raise SystemExit(1)


def _fail(_: Path) -> None:
    raise KeyError("cup")


def _die(_: Path) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _sleep(_: Path) -> None:
    time.sleep(60)


CASES = {
    "refused": (_refuse, "sentence"),
    "refused with status 1": (_refuse_on_the_command_line, "sentence"),
    "put right": (lambda _: "right", "right"),
    "passed on": (lambda _: None, "silent"),
    "failed": (_fail, "traceback"),
    "died": (_die, "signal"),
    "slept": (_sleep, "hang"),
}


def test_outcomes_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "SECONDS", 3.0)
    cases = [Case("any", name, act, ("glass",)) for name, (act, _) in CASES.items()]
    found = {outcome.case.name: outcome.result for outcome in runner.run_cases(cases, 4)}
    assert found == {name: result for name, (_, result) in CASES.items()}


def test_a_sentence_must_name_what_came() -> None:
    vague = Case("any", "vague", _refuse, ("bowl",))
    [outcome] = runner.run_cases([vague], 1)
    assert outcome.result == "vague" and outcome.result in BAD
