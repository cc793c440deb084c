"""A drive without a front end: any thread may watch and command, one thread drives."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.drive.hints import read_instruction
from lerobot_llakey.drive.pilot import ROW, Pilot
from lerobot_llakey.drive.ride import VIEWER, Ride
from lerobot_llakey.drive.snapshot import Snapshot
from lerobot_llakey.policies.hierarchy.commanders.corrections import Hold
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.tasks import parse_tasks


class Session:
    """A person's drive with a policy.

    Commands return at once; :meth:`snapshot` says what has come of them, :meth:`settle` and :meth:`wait_for` wait. They
    are carried out in order by one worker thread, which owns the simulator with its OpenGL context, and the policy. A
    correction or another goal is taken up between steps alone, and a new proposal is made with it: a step always
    carries out the proposal that was shown.

    Args:
        pilot: the policy.
        make_env: makes the environment of a task.
        output_dir: where episodes are written (see :class:`~lerobot_llakey.drive.ride.Ride`).
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
        self.free_text = pilot.corrections.free_text
        self._corrections = pilot.corrections
        self._ride = Ride(pilot, make_env, output_dir, self._show_frame)
        self._split, self._pause_seconds = split, pause_seconds
        self._changed = threading.Condition()
        self._snapshot = Snapshot()
        self._closed = False
        self._going = False  # whether a job that goes on is queued or at work
        self._wishes: list[Callable[[], object]] = []
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="drive")

    # What front ends ask.

    def snapshot(self) -> Snapshot:
        """The present moment."""
        with self._changed:
            return self._snapshot

    def wait_for(self, condition: Callable[[Snapshot], bool], timeout: float | None = None) -> Snapshot:
        """The first snapshot that fulfils a condition, or the last one when the time (seconds) is over."""
        with self._changed:
            self._changed.wait_for(lambda: condition(self._snapshot), timeout)
            return self._snapshot

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
            ValueError: if the task is unknown or more than one, or the seed out of range.
        """
        tasks = parse_tasks(task)
        if len(tasks) != 1:
            raise ValueError(f"Expected one task, got {task!r}; name one, and start the others later.")
        schema.scene_seed(self._split, seed)
        with self._changed:
            self._wishes.clear()
            self._publish(phase="preparing", running=False, proposal=None, note="")
        self._submit(lambda: self._begin(tasks[0], seed))

    def step(self) -> None:
        """Carry the proposal out.

        Raises:
            ValueError: if there is no proposal, a correction has not become one yet, or the drive is running.
        """
        with self._changed:
            now = self._snapshot
            phase = "preparing" if self._wishes and now.phase == "waiting" else now.phase
            if phase != "waiting" or now.running:
                state = "a running drive" if now.running else f"a drive that is {phase}"
                raise ValueError(f"Expected a drive that waits with a proposal, got {state}; pause, or start one.")
            self._publish(phase="moving")
        self._submit(self._step)

    def run(self) -> None:
        """Carry out proposal after proposal until :meth:`pause`, success or the end.

        Raises:
            ValueError: if there is no episode.
        """
        with self._changed:
            if self._snapshot.running:
                return
            if self._snapshot.phase in ("over", "failed"):
                raise ValueError(f"Expected an episode, got a drive that is {self._snapshot.phase}; start one first.")
            self._publish(running=True, note="")
            if self._going:
                return
            self._going = True
        self._submit(self._go_on)

    def pause(self) -> None:
        """Let the present step be the last one for now."""
        self._publish(running=False)

    def stop(self) -> None:
        """End the episode after the present step, and write its video."""
        self._publish(running=False)
        self._submit(self._end)

    def correct(self, text: str, hold: Hold = "once") -> str:
        """Put a person's words in the place of the proposal.

        Args:
            text: a basic action in any of its wordings.
            hold: "once" for one step, "done" until it is done.

        Returns:
            The instruction in its canonical wording.

        Raises:
            ValueError: if the text is no basic action, or there is no episode; nothing changes then.
        """
        instruction = text.strip() if self.free_text else read_instruction(text, self.known)
        self._wish(lambda: self._corrections.say(ROW, instruction, hold))
        return instruction

    def withdraw(self) -> None:
        """Take the correction back, so that the policy proposes again."""
        self._wish(lambda: self._corrections.withdraw(ROW))

    def change_goal(self, text: str) -> None:
        """Give the policy another skill instruction, "" for the scene's own; the simulator judges the latter alone."""
        self._wish(lambda: self._corrections.change_task(ROW, text))

    def tell(self, note: str) -> None:
        """Show the person a note."""
        self._publish(note=note)

    def close(self) -> None:
        """End the episode, write its video and free the simulator; the session is over then, for good."""
        if self._closed:
            return
        self._closed = True
        self._publish(running=False)
        self._submit(self._ride.close)
        self._worker.shutdown(wait=True)

    # What the worker does.

    def _begin(self, task: str, seed: int) -> None:
        self._publish(phase="preparing")
        self._ride.begin(task, seed)
        self._publish(task=task, seed=seed, steps=(), folder=self._ride.folder, video=None)
        self._propose()

    def _propose(self) -> None:
        with self._changed:
            wishes, self._wishes = self._wishes, []
        for wish in wishes:
            wish()
        proposal = self._ride.propose()
        self._publish(
            phase="waiting",
            proposal=proposal,
            held=self._corrections.held(ROW),
            own_goal=self._ride.own_goal,
            goal=self._ride.goal,
            pictures=self._ride.pictures,
        )

    def _take_wishes(self) -> None:
        if self._wishes and self._snapshot.phase == "waiting":
            self._propose()

    def _step(self) -> None:
        self._publish(phase="moving")
        driven = self._ride.step()
        steps = (*self._snapshot.steps, driven)
        if driven.result == "success":
            self._publish(steps=steps, running=False, note=f"Done after {len(steps)} steps.")
        else:
            self._publish(steps=steps, note=f"The arm did not move: {driven.failure}." if driven.failure else "")
        if self._ride.over:
            self._end()
            self._publish(note=f"Out of steps after {len(steps)}.")
        else:
            self._propose()

    def _go_on(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: bool(self._wishes) or not self._snapshot.running, self._pause_seconds)
                if not self._snapshot.running or self._snapshot.phase != "waiting":
                    self._going = False
                    return
                wished = bool(self._wishes)
            if not wished:
                break
            self._propose()
        self._step()
        with self._changed:
            self._going = self._snapshot.running
        if self._going:
            self._submit(self._go_on)

    def _end(self) -> None:
        video = self._ride.end()
        if video is not None:
            self._publish(phase="over", running=False, proposal=None, held=None, video=video, note="Stopped.")

    def _show_frame(self, frame: np.ndarray) -> None:
        self._publish(pictures={**self._snapshot.pictures, VIEWER: frame})

    # How it is kept in order.

    def _wish(self, wish: Callable[[], object]) -> None:
        with self._changed:
            if self._snapshot.phase in ("over", "failed"):
                raise ValueError(f"Expected an episode, got a drive that is {self._snapshot.phase}; start one first.")
            self._wishes.append(wish)
            self._publish(note="")
        self._submit(self._take_wishes)

    def _publish(self, **changes: Any) -> None:
        with self._changed:
            self._snapshot = replace(self._snapshot, version=self._snapshot.version + 1, **changes)
            self._changed.notify_all()

    def _submit(self, job: Callable[[], object]) -> None:
        self._worker.submit(self._guarded, job)

    def _guarded(self, job: Callable[[], object]) -> None:
        try:
            job()
        except Exception as error:  # the worker must live on, and the person must know
            logging.exception("The drive failed.")
            self._going = False
            self._publish(phase="failed", running=False, proposal=None, note=str(error))
