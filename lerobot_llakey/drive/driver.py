"""The thread that drives: what it does with commands, and what it tells the board."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from lerobot_llakey.drive.board import Board
from lerobot_llakey.drive.driven_episode import VIEWER, DrivenEpisode
from lerobot_llakey.drive.pilot import Pilot
from lerobot_llakey.sim.env import LlakeySimEnv


class Driver:
    """The jobs of a session's worker thread; all methods are called there.

    Args:
        pilot: the policy.
        make_env: makes the environment of a task.
        output_dir: where episodes are written.
        pause_seconds: how long a proposal is shown before it is carried out while the drive is running.
        board: told of all that happens.

    Attributes:
        wishes: what a person wants changed before the next proposal; used with ``board.changed`` held.
        left: steps until a counted run pauses, None for no limit; likewise.
        going: whether :meth:`go_on` is at work or will be; likewise.
    """

    def __init__(
        self,
        pilot: Pilot,
        make_env: Callable[[str], LlakeySimEnv],
        output_dir: Path,
        pause_seconds: float,
        board: Board,
    ) -> None:
        self.pause_seconds = pause_seconds
        self.wishes: list[Callable[[], object]] = []
        self.left: int | None = None
        self.going = False
        self._board = board
        self._episode = DrivenEpisode(pilot, make_env, output_dir, self._show_frame)

    def begin(self, task: str, seed: int) -> None:
        """Start an episode."""
        self._board.publish(phase="preparing")
        self._episode.begin(task, seed)
        self._board.publish(task=task, seed=seed, steps=(), folder=self._episode.folder, video=None)
        self._propose()

    def _propose(self) -> None:
        with self._board.changed:
            wishes, self.wishes = self.wishes, []
        for wish in wishes:
            wish()
        proposal = self._episode.propose()
        self._board.publish(
            phase="waiting",
            proposal=proposal,
            own_goal=self._episode.own_goal,
            goal=self._episode.goal,
            pictures=self._episode.pictures,
        )

    def take_wishes(self) -> None:
        """Make a new proposal if a person wants one."""
        if self.wishes and self._board.now.phase == "waiting":
            self._propose()

    def step(self) -> None:
        """Carry the proposal out."""
        self._board.publish(phase="moving")
        driven = self._episode.step()
        steps = (*self._board.now.steps, driven)
        if driven.result == "success":
            self._board.publish(steps=steps, running=False, note=f"Done after {len(steps)} steps.")
        else:
            self._board.publish(steps=steps, note=f"The arm did not move: {driven.failure}." if driven.failure else "")
        if self._episode.over:
            self.end()
            self._board.publish(note=f"Out of steps after {len(steps)}.")
        else:
            self._propose()

    def go_on(self) -> bool:
        """Show the proposal for a while, then carry it out, while the drive is running.

        Returns:
            Whether to go on after this step.
        """
        while True:
            with self._board.changed:
                self._board.changed.wait_for(self._disturbed, self.pause_seconds)
                if not self._board.now.running or self._board.now.phase != "waiting":
                    self.going = False
                    return False
                wished = bool(self.wishes)
            if not wished:
                break
            self._propose()
        self.step()
        with self._board.changed:
            self.left = None if self.left is None else self.left - 1
            if self.left == 0:
                self._board.publish(running=False)
            self.going = self._board.now.running
            return self.going

    def end(self) -> None:
        """End the episode."""
        video = self._episode.end()
        if video is not None:
            self._board.publish(phase="over", running=False, proposal=None, video=video, note="Stopped.")

    def close(self) -> None:
        """End the episode and free the simulator."""
        self._episode.close()

    def _disturbed(self) -> bool:
        return bool(self.wishes) or not self._board.now.running

    def _show_frame(self, frame: np.ndarray) -> None:
        self._board.publish(pictures={**self._board.now.pictures, VIEWER: frame})
