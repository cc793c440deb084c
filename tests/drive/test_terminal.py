"""A drive by lines of text, through a pipe as a script would."""

import os

import pytest

from lerobot_llakey.drive.session import Session
from lerobot_llakey.drive.terminal import Terminal


def _talk(session: Session, lines: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> str:
    """What the terminal prints while it reads lines from a pipe."""
    read, write = os.pipe()
    with os.fdopen(write, "w") as sender:
        sender.write("".join(f"{line}\n" for line in lines))
    with os.fdopen(read) as receiver:
        monkeypatch.setattr("sys.stdin", receiver)
        Terminal(session).talk()
    return capsys.readouterr().out


def test_a_drive_from_start_to_stop(
    session: Session, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    session.start("open_drawer", 3)
    lines = [
        "gras the handle",
        "lift the robotic arm",
        "",
        "goal open the bottom drawer",
        "goal",
        "run",
        "steps",
        "stop",
    ]
    printed = _talk(session, lines, monkeypatch, capsys)
    assert "Expected a basic action, got 'gras the handle'" in printed
    assert "next: raise the robotic arm  [person]" in printed
    assert "goal (yours): open the bottom drawer" in printed
    assert "  1  raise the robotic arm  [person, -]  to (" in printed
    assert "pull the top drawer open  [policy, 90 %]" in printed and ": success" in printed
    now = session.snapshot()
    assert now.phase == "over" and len(now.steps) == 4 and f"over; steps and video: {now.folder}" in printed
    assert (now.folder / "view.jpg").stat().st_size > 1000


def test_other_scenes_held_words_and_counted_runs(
    session: Session, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    session.start("open_drawer", 3)
    lines = ["hold grasp the moon", "run 2", "take back", "new nowhere", "new 4", "steps", "quit", "stop"]
    printed = _talk(session, lines, monkeypatch, capsys)
    assert printed.count("grasp the moon  [person, -]  to (500") == 2 and printed.count("unreachable") >= 2
    assert "Expected new SEED or new TASK SEED, got 'new nowhere'" in printed
    assert "nothing was done yet" in printed
    now = session.snapshot()
    assert (now.task, now.seed, now.phase) == ("open_drawer", 4, "waiting")  # "stop" came after "quit"
