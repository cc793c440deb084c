"""Corrections: what each does, what it refuses, that it is in the file at once, and that it can be undone."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.keyframe_file import read_keyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.labelling import session as sessions
from lerobot_llakey.labelling.session import LabelSession

GRASP, RAISE = "grasp the cup", "raise the robotic arm"


@pytest.fixture
def session(found: list[FoundKeyframes], tmp_path: Path) -> LabelSession:
    return LabelSession(found, tmp_path / "a.csv", BASIC_GRAMMAR)


def _frames(session: LabelSession, episode: int = 0) -> list[int]:
    return [keyframe.frame for keyframe in session.keyframes(episode)]


def _texts(session: LabelSession, episode: int = 0) -> list[str]:
    return [keyframe.instruction for keyframe in session.keyframes(episode)]


def test_keyframes_begin_as_discovered_and_nothing_is_written(session: LabelSession) -> None:
    assert _frames(session) == [10, 20, 39] and not session.path.exists()


def test_keyframes_are_moved_added_and_removed_with_their_instructions(session: LabelSession) -> None:
    for frame, text in zip((10, 20, 39), ("a", "b", "c"), strict=True):
        session.say(0, frame, text)
    session.move(0, 10, 19)
    assert (_frames(session), _texts(session)) == ([19, 20, 39], ["a", "b", "c"])
    session.add(0, 5)
    assert (_frames(session), _texts(session)) == ([5, 19, 20, 39], ["", "a", "b", "c"])
    session.remove(0, 19)
    assert (_frames(session), _texts(session)) == ([5, 20, 39], ["", "b", "c"])
    session.say(0, 20, "")
    session.say(0, 5, "  move   there ")
    session.remove(0, 5)
    assert (_frames(session), _texts(session)) == ([20, 39], ["move there", "c"])
    assert _frames(session, 1) == [10, 20, 39]


def test_every_correction_is_in_the_file_at_once_and_another_session_goes_on(
    session: LabelSession, found: list[FoundKeyframes]
) -> None:
    for correct in (
        lambda: session.say(0, 10, GRASP),
        lambda: session.move(0, 10, 12),
        lambda: session.add(1, 5),
        lambda: session.remove(1, 10),
        lambda: session.undo(),
        lambda: session.redo(),
    ):
        correct()
        stored = read_keyframes(session.path, found)
        assert stored == {episode: session.keyframes(episode) for episode in session.found}
    again = LabelSession(found, session.path, BASIC_GRAMMAR)
    assert again.keyframes(0) == session.keyframes(0) and again.keyframes(1) == session.keyframes(1)


@pytest.mark.parametrize(
    ("correct", "sentence"),
    [
        (lambda one: one.move(0, 10, 20), "Expected a frame from 1 to 19, between its neighbours, got 20"),
        (lambda one: one.move(0, 20, 10), "Expected a frame from 11 to 38"),
        (lambda one: one.move(0, 11, 12), r"Expected a keyframe out of \[10, 20, 39\], got frame 11"),
        (lambda one: one.move(0, 39, 38), "Expected the last frame 39 to stay a keyframe"),
        (lambda one: one.remove(0, 39), "Expected the last frame 39 to stay a keyframe"),
        (lambda one: one.add(0, 10), "Expected a frame from 1 to 39 that is no keyframe yet, got 10"),
        (lambda one: one.add(0, 0), "got 0"),
        (lambda one: one.add(0, 40), "got 40"),
        (lambda one: one.say(0, 5, "a"), "got frame 5"),
        (lambda one: one.say(0, 10, "a" * 401), "Expected at most 400 characters, got 401"),
        (lambda one: one.say(7, 10, "a"), "Expected an episode of 3, got 7"),
        (lambda one: one.undo(), "Expected a correction to take back, got none"),
        (lambda one: one.redo(), "Expected a correction to make again, got none"),
    ],
)
def test_what_makes_no_sense_is_refused_and_changes_nothing(
    correct: Callable[[LabelSession], None], sentence: str, session: LabelSession
) -> None:
    with pytest.raises(LlakeyError, match=sentence):
        correct(session)
    assert _frames(session) == [10, 20, 39] and not session.path.exists()


def test_corrections_are_undone_and_made_again_in_their_episodes(session: LabelSession) -> None:
    session.move(0, 10, 12)
    session.say(1, 10, GRASP)
    session.say(1, 10, GRASP)  # nothing new: nothing to undo
    assert session.undo() == 1 and _texts(session, 1) == ["", "", ""]
    assert session.undo() == 0 and _frames(session) == [10, 20, 39]
    assert session.redo() == 0 and _frames(session) == [12, 20, 39]
    session.add(0, 5)
    with pytest.raises(LlakeyError, match="to make again, got none"):
        session.redo()


def test_only_the_latest_corrections_can_be_undone(session: LabelSession, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sessions, "MOST_UNDONE", 2)
    for text in ("a", "b", "c"):
        session.say(0, 10, text)
    session.undo()
    session.undo()
    assert _texts(session)[0] == "a"
    with pytest.raises(LlakeyError, match="got none"):
        session.undo()


def test_what_cannot_be_written_is_not_kept(session: LabelSession, monkeypatch: pytest.MonkeyPatch) -> None:
    session.say(0, 10, "a")

    def full(*arguments: object) -> None:
        raise LlakeyError("Expected to write, got refused (no space left on device); choose another place.")

    monkeypatch.setattr(sessions, "write_keyframes", full)
    for correct in (lambda: session.say(0, 10, "b"), session.undo):
        with pytest.raises(LlakeyError, match="no space left"):
            correct()
        assert _texts(session)[0] == "a"
    monkeypatch.undo()
    session.undo()
    assert _texts(session)[0] == ""


def test_an_episode_is_complete_with_instructions_of_the_grammar_alone(session: LabelSession) -> None:
    for frame, text in ((10, "go there"), (20, GRASP)):
        session.say(0, frame, text)
        assert not session.complete(0)
    session.say(0, 39, RAISE)
    assert not session.complete(0)
    session.say(0, 10, "move to the top of the cup")
    assert session.complete(0) and not session.complete(1)


def test_an_episode_is_filled_as_one_of_the_same_task(session: LabelSession) -> None:
    assert session.alike(1) is None
    for frame, text in ((10, "move to the top of the cup"), (20, GRASP), (39, RAISE)):
        session.say(0, frame, text)
    assert session.alike(1) == 0 and session.alike(2) is None and session.alike(0) is None
    session.say(1, 20, "grasp the mug")
    session.fill(1, 0)
    assert _texts(session, 1) == ["move to the top of the cup", "grasp the mug", RAISE]
    session.add(1, 5)
    assert session.alike(1) is None
    with pytest.raises(LlakeyError, match="Expected an episode of 4 segments to copy from, got episode 0 with 3"):
        session.fill(1, 0)


def test_texts_are_counted_by_task_and_segment(session: LabelSession) -> None:
    for episode in (0, 1, 2):
        session.say(episode, 10, GRASP)
    assert dict(session.texts()) == {("lift the cup", 0, GRASP): 2, ("open the drawer", 0, GRASP): 1}
