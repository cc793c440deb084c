"""A drive without a front end: any thread may watch and command, one thread drives."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, get_args

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count
from lerobot_llakey.drive.board import Board
from lerobot_llakey.drive.driver import Driver
from lerobot_llakey.drive.hints import read_instruction
from lerobot_llakey.drive.pilot import ROW, Pilot
from lerobot_llakey.drive.snapshot import Snapshot
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.corrections import Hold
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.tasks import parse_tasks

LONGEST_GOAL = 1000
"""Characters of the longest text that a drive takes from a person."""


class Session:
    """A person's drive with a policy.

    Commands return at once; :meth:`snapshot` says what has come of them, :meth:`settle` and :meth:`wait_for` wait. They
    are carried out in order by one worker thread, which owns the simulator with its OpenGL context, and the policy. A
    correction or another goal is taken up between steps alone, and a new proposal is made with it: a step always
    carries out the proposal that was shown.

    Args:
        pilot: the policy.
        make_env: makes the environment of a task.
        output_dir: where episodes are written (see :class:`~lerobot_llakey.drive.driven_episode.DrivenEpisode`).
        split: of the scene seeds that ``make_env`` takes.
        pause_seconds: how long a proposal is shown before it is carried out while the drive is running.
    """

    def __init__(
        self,
        pilot: Pilot,
        make_env: Callable[[str], LlakeySimEnv],
        output_dir: Path,
        split: str = "test",
        pause_seconds: float = 1.0,
    ) -> None:
        self.known = pilot.known
        self.grammar = pilot.corrections.grammar
        self._corrections = pilot.corrections
        self._split = split
        self._board = Board()
        self._driver = Driver(pilot, make_env, output_dir, pause_seconds, self._board)
        self._closed = False
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="drive")

    # What front ends ask.

    def snapshot(self) -> Snapshot:
        """The present moment."""
        return self._board.now

    def wait_for(self, condition: Callable[[Snapshot], bool], timeout: float | None = None) -> Snapshot:
        """The first moment that fulfils a condition, or the last one when the time (seconds) is over."""
        return self._board.wait_for(condition, timeout)

    def settle(self) -> Snapshot:
        """The snapshot after all commands given so far; a running drive goes on afterwards."""
        self._worker.submit(lambda: None).result()
        return self.snapshot()

    # What a person commands.

    def start(self, task: str, seed: int) -> None:
        """Start an episode in place of the present one.

        Args:
            task: name of one task.
            seed: index of the scene within the split.

        Raises:
            LlakeyError: if the task is unknown or more than one, or the seed out of range.
        """
        tasks = parse_tasks(_text("a task's name", task))
        if len(tasks) != 1:
            raise LlakeyError(f"Expected one task, got {task!r}; name one, and start the others later.")
        require_count("the scene", seed)
        schema.scene_seed(self._split, seed)
        with self._board.changed:
            self._driver.wishes.clear()
            self._board.publish(phase="preparing", running=False, proposal=None, note="", task=tasks[0], seed=seed)
        self._submit(lambda: self._driver.begin(tasks[0], seed))

    def step(self) -> None:
        """Carry the proposal out.

        Raises:
            LlakeyError: if there is no proposal, a correction has not become one yet, or the drive is running.
        """
        with self._board.changed:
            now = self._board.now
            phase = "preparing" if self._driver.wishes and now.phase == "waiting" else now.phase
            if phase != "waiting" or now.running:
                state = "a running drive" if now.running else f"a drive that is {phase}"
                raise LlakeyError(f"Expected a drive that waits with a proposal, got {state}; pause, or start one.")
            self._board.publish(phase="moving")
        self._submit(self._driver.step)

    def run(self, steps: int | None = None) -> None:
        """Carry out proposal after proposal until :meth:`pause`, success or the end.

        Args:
            steps: at most so many; None for no limit.

        Raises:
            LlakeyError: if there is no episode, or no step to take.
        """
        if steps is not None:
            require_count("the steps to run", steps, 1)
        with self._board.changed:
            if self._board.now.running:
                return
            if self._board.now.phase in ("over", "failed"):
                raise LlakeyError(f"Expected an episode, got a drive that is {self._board.now.phase}; start one first.")
            self._driver.left = steps
            self._board.publish(running=True, note="")
            if self._driver.going:
                return
            self._driver.going = True
        self._submit(self._go_on)

    def pause(self) -> None:
        """Let the present step be the last one for now."""
        self._board.publish(running=False)

    def stop(self) -> None:
        """End the episode after the present step, and write its video."""
        self._board.publish(running=False)
        self._submit(self._driver.end)

    def correct(self, text: str, hold: Hold = "once") -> str:
        """Put a person's words in the place of the proposal.

        Args:
            text: a basic action in any of its wordings.
            hold: "once" for one step, "done" until it is done.

        Returns:
            The instruction in its canonical wording.

        Raises:
            LlakeyError: if the text is no basic action, or there is no episode; nothing changes then.
        """
        text = _text("an instruction", text, LONGEST_GOAL if self.grammar.is_free else None)
        if hold not in get_args(Hold):
            raise LlakeyError(f"Expected how long the words hold, out of {get_args(Hold)}, got {hold!r}; pick one.")
        instruction = read_instruction(text, self.known, self.grammar)
        self._wish(lambda: self._corrections.say(ROW, instruction, hold))
        return instruction

    def withdraw(self) -> None:
        """Take the correction back, so that the policy proposes again."""
        self._wish(lambda: self._corrections.withdraw(ROW))

    def change_goal(self, text: str) -> None:
        """Give the policy another skill instruction, "" for the scene's own; the simulator judges the latter alone.

        Raises:
            LlakeyError: if it is no text or longer than ``LONGEST_GOAL``, or there is no episode; nothing changes then.
        """
        text = _text("a goal", text)
        self._wish(lambda: self._corrections.change_task(ROW, text))

    def tell(self, note: str) -> None:
        """Show the person a note."""
        self._board.publish(note=note)

    def close(self) -> None:
        """End the episode, write its video and free the simulator; the session is over then, for good."""
        if self._closed:
            return
        self._closed = True
        self._board.publish(running=False)
        self._submit(self._driver.close)
        self._worker.shutdown(wait=True)

    # How it is kept in order.

    def _go_on(self) -> None:
        if self._driver.go_on():
            self._submit(self._go_on)

    def _wish(self, wish: Callable[[], object]) -> None:
        with self._board.changed:
            if self._board.now.phase in ("over", "failed"):
                raise LlakeyError(f"Expected an episode, got a drive that is {self._board.now.phase}; start one first.")
            self._driver.wishes.append(wish)
            self._board.publish(note="")
        self._submit(self._driver.take_wishes)

    def _submit(self, job: Callable[[], object]) -> None:
        self._worker.submit(self._guarded, job)

    def _guarded(self, job: Callable[[], object]) -> None:
        try:
            job()
        except Exception as error:  # the worker must live on, and the person must know
            logging.exception("The drive failed.")
            self._driver.going = False
            self._board.publish(phase="failed", running=False, proposal=None, note=str(error))


def _text(what: str, value: Any, longest: int | None = LONGEST_GOAL) -> str:
    """What came from a front end, if it is a text; pages of others send anything.

    Raises:
        LlakeyError: if it is none, or longer than ``longest``.
    """
    if not isinstance(value, str):
        raise LlakeyError(f"Expected {what} as text, got {type(value).__name__}; write it in words.")
    if longest is not None and len(value) > longest:
        raise LlakeyError(f"Expected {what} of at most {longest} characters, got {len(value)}; say it in fewer words.")
    return value
