"""A session drives in one thread what any thread commands, and shows every step before it is done."""

import json
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from fakes_videos import frames_of
from lerobot_llakey import schema
from lerobot_llakey.drive.session import Session

RAISE = "raise the robotic arm"


def _start(session: Session, task: str = "open_drawer", seed: int = 3) -> Any:
    session.start(task, seed)
    return session.settle()


def _lines(folder: Path | None) -> list[dict[str, Any]]:
    assert folder is not None
    return [json.loads(line) for line in (folder / "steps.jsonl").read_text().splitlines()]


def test_what_is_proposed_is_shown_before_it_is_done(session: Session) -> None:
    now = _start(session)
    assert now.phase == "waiting" and now.steps == ()
    assert now.goal == now.own_goal and "top" in now.goal
    assert set(now.pictures) == {*schema.CAMERAS, "viewer"}
    assert now.proposal.instruction == "move to the front of the top handle"
    assert (now.proposal.source, now.proposal.likelihood) == ("policy", 0.9)
    session.step()
    after = session.settle()
    assert [step.step.instruction for step in after.steps] == [now.proposal.instruction]
    assert after.steps[0].step.likelihood == 0.9 and after.steps[0].result == "moved"
    assert after.proposal.instruction == "grasp the top handle" and after.phase == "waiting"


def test_a_run_ends_with_success_and_leaves_log_and_video(session: Session) -> None:
    _start(session)
    session.run()
    now = session.wait_for(lambda moment: not moment.running, 60)
    assert [step.result for step in now.steps] == ["moved", "moved", "success"] and "Done" in now.note
    session.stop()
    over = session.settle()
    assert over.phase == "over" and over.proposal is None and over.video == over.folder / "video.mp4"
    lines = _lines(over.folder)
    assert [line["result"] for line in lines] == ["moved", "moved", "success"]
    assert lines[0]["instruction"] == "move to the front of the top handle" and lines[0]["source"] == "policy"
    assert lines[0]["likelihood"] == 0.9 and len(lines[0]["sent"]) == schema.ACTION_DIM
    assert lines[0]["scene"] == {"task": "open_drawer", "seed": 3, "split": "test"}
    assert len(frames_of(over.video)) > 15 and [file.name for file in over.folder.glob(".*")] == []


def test_pausing_keeps_the_drive_where_it_is(session: Session) -> None:
    session._driver.pause_seconds = 30.0  # a proposal stands until someone says something
    _start(session)
    session.run()
    assert session.snapshot().running
    with pytest.raises(ValueError, match="got a running drive; pause"):
        session.step()
    session.pause()
    now = session.settle()
    assert now.phase == "waiting" and not now.running and now.steps == ()


def test_a_run_can_be_paused_and_taken_up_at_once(session: Session) -> None:
    _start(session)
    for _ in range(5):
        session.run()
        session.pause()
    session.run()
    now = session.wait_for(lambda moment: not moment.running, 60)
    assert [step.result for step in now.steps] == ["moved", "moved", "success"]


def test_a_correction_takes_the_proposals_place_for_one_step(session: Session) -> None:
    first = _start(session).proposal
    assert session.correct("Lift the robotic arm.") == RAISE
    now = session.settle()
    assert now.steps == () and now.held == RAISE
    assert (now.proposal.instruction, now.proposal.source) == (RAISE, "person")
    session.step()
    after = session.settle()
    assert after.steps[0].step.source == "person" and after.steps[0].result == "moved"
    assert after.held is None and after.proposal.instruction == first.instruction


def test_a_correction_can_hold_until_it_is_done(session: Session) -> None:
    _start(session)
    session.correct("grasp the moon", "done")
    for _ in range(2):
        session.settle()
        session.step()
    now = session.settle()
    assert [step.result for step in now.steps] == ["unreachable", "unreachable"]
    assert "did not move: unreachable" in now.note and now.held == "grasp the moon"
    session.correct(RAISE, "done")
    session.settle()
    session.step()
    assert session.settle().held is None  # it arrived


def test_nothing_is_done_that_was_not_shown(session: Session) -> None:
    _start(session)
    busy = threading.Event()
    session._worker.submit(busy.wait)
    session.correct(RAISE)
    with pytest.raises(ValueError, match="got a drive that is preparing"):
        session.step()
    busy.set()
    assert session.settle().proposal.instruction == RAISE
    session.step()
    assert session.settle().steps[0].step.instruction == RAISE


def test_a_correction_can_be_taken_back(session: Session) -> None:
    first = _start(session).proposal
    session.correct(RAISE)
    assert session.settle().proposal.source == "person"
    session.withdraw()
    now = session.settle()
    assert now.proposal == first and now.held is None


def test_words_outside_the_grammar_change_nothing_and_are_explained(session: Session) -> None:
    before = _start(session)
    with pytest.raises(ValueError, match=r"got 'gras the handel'.*grasp <thing>.*Nothing was moved\."):
        session.correct("gras the handel")
    assert session.settle() is before


def test_a_correction_during_a_run_is_shown_and_done_next(session: Session) -> None:
    session._driver.pause_seconds = 30.0
    _start(session)
    session.run()
    session.correct(RAISE)
    now = session.wait_for(lambda moment: moment.held == RAISE, 60)
    assert now.running and now.proposal.instruction == RAISE and now.steps == ()
    session.pause()
    session.settle()
    session.step()
    assert session.settle().steps[0].step.source == "person"


def test_the_goal_can_change_on_the_way(session: Session, script: Any) -> None:
    own_goal = _start(session).own_goal
    session.step()
    session.change_goal("open the bottom drawer")
    now = session.settle()
    assert now.goal == "open the bottom drawer" and now.own_goal == own_goal != now.goal
    assert script.goals[-1] == "open the bottom drawer" and len(now.steps) == 1
    session.run()
    session.wait_for(lambda moment: len(moment.steps) >= 3 or not moment.running, 60)
    session.pause()
    now = session.settle()
    assert now.steps[0].step.task == own_goal and now.steps[1].step.task == "open the bottom drawer"
    # The simulator judges the scene's own task, which the script goes on with; that is no success of the new goal.
    assert now.steps[2].result == "moved; the scene's own task is done"
    session.change_goal("")
    assert session.settle().goal == own_goal


def test_another_scene_forgets_corrections_and_goal(session: Session) -> None:
    first = _start(session)
    session.correct(RAISE, "done")
    session.change_goal("open the bottom drawer")
    session.settle()
    now = _start(session, "close_jar", 1)
    assert now.held is None and now.goal == now.own_goal != first.own_goal and now.proposal.source == "policy"
    assert (now.task, now.seed, now.steps, now.video) == ("close_jar", 1, (), None)
    assert (first.folder / "video.mp4").stat().st_size > 500  # the one before was ended
    again = _start(session)
    assert again.folder.name == "open_drawer_003_2"


def test_a_drive_out_of_steps_is_over(session: Session) -> None:
    _start(session)
    for _ in range(6):
        session.correct(RAISE)
        session.settle()
        session.step()
        session.settle()
    now = session.snapshot()
    assert now.phase == "over" and "Out of steps after 6" in now.note and now.video.exists()
    with pytest.raises(ValueError, match="got a drive that is over"):
        session.step()
    with pytest.raises(ValueError, match="start one first"):
        session.run()
    with pytest.raises(ValueError, match="start one first"):
        session.correct(RAISE)


@pytest.mark.parametrize(
    ("task", "seed", "message"),
    [
        ("open_door", 0, "got 'open_door'"),
        ("open_drawer,close_jar", 0, "Expected one task"),
        ("close_jar", -1, "Expected the scene to be a whole number of 0 or more"),
    ],
)
def test_a_scene_that_does_not_exist_is_told_at_once(session: Session, task: str, seed: int, message: str) -> None:
    before = _start(session)
    with pytest.raises(ValueError, match=message):
        session.start(task, seed)
    assert session.settle() is before


def test_a_failure_is_told_and_another_scene_can_be_started(session: Session, script: Any) -> None:
    _start(session)
    script.ask = lambda *arguments, **options: 1 / 0
    session.step()
    now = session.settle()
    assert now.phase == "failed" and "division by zero" in now.note and not now.running
    del script.ask
    assert _start(session).phase == "waiting"


def test_many_threads_may_watch_and_command(session: Session) -> None:
    _start(session)
    session.run()
    versions: list[list[int]] = []

    def meddle(command: Callable[[], object]) -> None:
        seen = []
        for _ in range(20):
            with suppress(ValueError):
                command()
            seen.append(session.snapshot().version)
        versions.append(seen)

    commands = [lambda: session.correct(RAISE), session.withdraw, session.pause, session.run, session.step]
    threads = [threading.Thread(target=meddle, args=(command,)) for command in commands]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    session.stop()
    now = session.settle()
    assert now.phase == "over" and all(seen == sorted(seen) for seen in versions) and len(versions) == len(commands)
    assert [step.step.index for step in now.steps] == list(range(len(now.steps)))
    assert len(_lines(now.folder)) == len(now.steps) if now.steps else True


def test_closing_ends_the_episode(session: Session) -> None:
    folder = _start(session).folder
    session.close()
    assert (folder / "video.mp4").exists()


@pytest.mark.parametrize("task", [None, 3, ["open_drawer"], "o" * 10_000_000, "open_drawer,close_jar", ""])
def test_a_task_that_is_none_is_refused(session: Session, task: Any) -> None:
    with pytest.raises(ValueError, match="Expected") as error:
        session.start(task, 0)
    assert session.snapshot().task == "" and len(str(error.value)) < 500


@pytest.mark.parametrize("seed", [None, "3", 1.0, True, -1, 10**12, [3]])
def test_a_scene_that_is_none_is_refused(session: Session, seed: Any) -> None:
    with pytest.raises(ValueError, match="Expected"):
        session.start("open_drawer", seed)


def test_texts_of_front_ends_are_held_to_kind_and_length(session: Session) -> None:
    session.start("open_drawer", 3)
    assert (session.snapshot().task, session.snapshot().seed) == ("open_drawer", 3)  # known at once
    for text in (None, 7, ["raise the robotic arm"], "g" * 10_000_000):
        for command in (session.correct, session.change_goal):
            with pytest.raises(ValueError, match="Expected") as error:
                command(text)
            assert len(str(error.value)) < 900
    with pytest.raises(ValueError, match="how long the words hold"):
        session.correct("raise the robotic arm", None)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="the steps to run"):
        session.run("all")  # type: ignore[arg-type]
    assert session.settle().phase == "waiting" and session.snapshot().goal == session.snapshot().own_goal
