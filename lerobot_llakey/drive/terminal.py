"""``llakey drive --terminal``: a drive by lines of text."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from lerobot_llakey.drive.driven_step import DrivenStep
from lerobot_llakey.drive.session import Session
from lerobot_llakey.drive.snapshot import Snapshot
from lerobot_llakey.drive.views import jpeg, one_picture
from lerobot_llakey.errors import LlakeyError

HELP = """\
  (empty line)         carry the proposal out
  INSTRUCTION          put it in the proposal's place for one step: grasp the red block
  hold INSTRUCTION     the same until it is done
  take back            let the policy propose again
  goal TEXT            change the goal; without a text, back to the scene's own
  run [N]              go on by itself, for N steps or until it is done (Ctrl-C pauses)
  new [TASK] SEED      another scene
  steps                what was done so far
  stop                 end the episode and write its video
  help, quit"""
PICTURE_FILE = "view.jpg"
"""The present pictures, in the episode's folder, for an image viewer beside the terminal."""


class Terminal:
    """Reads commands, one a line, and prints what comes of them.

    Args:
        session: with an episode started.
        ask: prints a prompt and returns a line; raises EOFError at the end of the input.
        say: prints a text.
    """

    def __init__(self, session: Session, ask: Callable[[str], str] = input, say: Callable[[str], None] = print) -> None:
        self._session, self._ask, self._say = session, ask, say

    def talk(self) -> None:
        """Read and obey until ``quit`` or the end of the input."""
        self._say(HELP)
        self._show(self._session.settle(), 0)
        while True:
            try:
                line = self._ask("drive> ").strip()
            except (EOFError, KeyboardInterrupt):
                return
            if line == "quit":
                return
            try:
                self._obey(line)
            except ValueError as error:
                self._say(str(error))

    def _obey(self, line: str) -> None:
        session = self._session
        before = session.snapshot()
        word, _, rest = line.partition(" ")
        rest = rest.strip()
        if line == "help":
            return self._say(HELP)
        if line == "steps":
            return self._say("\n".join(map(step_line, before.steps)) or "nothing was done yet")
        if word == "run" and (not rest or rest.isdecimal()):
            return self._run(int(rest) if rest else None)
        if not line:
            session.step()
        elif line == "stop":
            session.stop()
        elif line == "take back":
            session.withdraw()
        elif word == "goal":
            session.change_goal(rest)
        elif word == "new":
            *task, seed = rest.split() or [""]
            if not seed.isdecimal():
                raise LlakeyError(f"Expected new SEED or new TASK SEED, got {line!r}; give the number of a scene.")
            session.start(task[0] if task else before.task, int(seed))
            return self._show(session.settle(), 0)
        elif word == "hold":
            session.correct(rest, "done")
        else:
            session.correct(line)
        return self._show(session.settle(), len(before.steps))

    def _run(self, steps: int | None) -> None:
        shown = len(self._session.snapshot().steps)
        self._session.run(steps)
        try:
            while True:
                now = self._session.wait_for(partial(_news, shown))
                if not now.running:
                    break
                self._say("\n".join(map(step_line, now.steps[shown:])))
                shown = len(now.steps)
        except KeyboardInterrupt:
            self._session.pause()
        self._show(self._session.settle(), shown)

    def _show(self, now: Snapshot, shown: int) -> None:
        """Print the steps after the first ``shown``, and where things stand."""
        for step in now.steps[shown:]:
            self._say(step_line(step))
        if now.folder is not None and now.pictures:
            (now.folder / PICTURE_FILE).write_bytes(jpeg(one_picture(now.pictures)))
        for line in standing(now):
            self._say(line)


def _news(shown: int, now: Snapshot) -> bool:
    """Whether a run has got beyond the first ``shown`` steps, or ended."""
    return len(now.steps) > shown or not now.running


def step_line(step: DrivenStep) -> str:
    """One step in one line."""
    record = step.step
    words = f"{record.index + 1:3d}  {record.instruction}  [{record.source}, {step.likelihood}]"
    return f"{words}  to {step.pose}: {step.result}"


def standing(now: Snapshot) -> list[str]:
    """Where a drive stands, in a few lines."""
    lines = [now.note] if now.note else []
    if now.phase == "over" and now.video is not None:
        lines.append(f"over; steps and video: {now.folder}")
    if now.proposal is not None:
        changed = "" if now.goal == now.own_goal else " (yours)"
        likelihood = "" if now.proposal.likelihood is None else f", {100 * now.proposal.likelihood:.0f} %"
        lines.append(f"goal{changed}: {now.goal}")
        lines.append(f"next: {now.proposal.instruction}  [{now.proposal.source}{likelihood}]")
    return lines
