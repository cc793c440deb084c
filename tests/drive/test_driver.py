"""The driver's jobs, one after the other in the test's own thread."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from lerobot_llakey.drive.board import Board
from lerobot_llakey.drive.driver import Driver
from lerobot_llakey.drive.pilot import ROW, Pilot
from lerobot_llakey.sim.env import LlakeySimEnv


@pytest.fixture
def board() -> Board:
    return Board()


@pytest.fixture
def driver(pilot: Pilot, make_env: Callable[[str], LlakeySimEnv], tmp_path: Path, board: Board) -> Iterator[Driver]:
    driver = Driver(pilot, make_env, tmp_path, 0.0, board)
    driver.begin("open_drawer", 3)
    yield driver
    driver.close()


def test_a_wish_during_a_run_is_shown_first(driver: Driver, board: Board, pilot: Pilot) -> None:
    shown = []
    board.publish(running=True)
    driver.wishes.append(lambda: pilot.corrections.say(ROW, "raise the robotic arm"))
    real, board.publish = board.publish, lambda **changes: (shown.append(changes), real(**changes))[1]  # type: ignore[method-assign]
    assert driver.go_on() is True and driver.wishes == []
    proposals = [changes["proposal"].source for changes in shown if "proposal" in changes]
    assert proposals == ["person", "policy"] and board.now.steps[0].step.source == "person"


def test_a_counted_run_pauses_by_itself(driver: Driver, board: Board) -> None:
    board.publish(running=True)
    driver.left = 1
    assert driver.go_on() is False
    assert len(board.now.steps) == 1 and not board.now.running and board.now.phase == "waiting"


def test_a_paused_run_does_nothing(driver: Driver, board: Board) -> None:
    assert driver.go_on() is False and board.now.steps == () and not driver.going


def test_a_wish_is_left_alone_while_the_arm_moves(driver: Driver, board: Board) -> None:
    driver.wishes.append(lambda: 1 / 0)
    board.publish(phase="moving")
    driver.take_wishes()
    assert len(driver.wishes) == 1
    driver.wishes.clear()
