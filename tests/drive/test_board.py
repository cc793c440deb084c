"""The board shows one moment at a time, and wakes those who wait."""

import threading

from lerobot_llakey.drive.board import Board


def test_a_change_is_a_new_snapshot_with_a_higher_version() -> None:
    board = Board()
    before = board.now
    board.publish(goal="tidy up", phase="waiting")
    assert (before.goal, before.version) == ("", 0)
    assert (board.now.goal, board.now.phase, board.now.version) == ("tidy up", "waiting", 1)


def test_who_waits_is_woken_by_another_thread() -> None:
    board = Board()
    thread = threading.Thread(target=lambda: [board.publish(seed=seed) for seed in range(5)])
    thread.start()
    assert board.wait_for(lambda now: now.seed == 4, 60).seed == 4
    thread.join()


def test_waiting_ends_with_the_time() -> None:
    assert Board().wait_for(lambda now: now.seed == 1, 0.0).seed == 0
