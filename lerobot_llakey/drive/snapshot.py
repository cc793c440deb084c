"""What anyone who watches a drive may know at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from lerobot_llakey.drive.driven_step import DrivenStep
from lerobot_llakey.policies.hierarchy.decision import Choice

Phase = Literal["preparing", "waiting", "moving", "over", "failed"]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A moment of a session; it never changes, a later moment is another snapshot.

    Attributes:
        version: grows with each change.
        phase: "preparing" a scene, "waiting" with a proposal, "moving", "over" (stopped, or out of steps) or "failed".
        running: whether proposals are carried out without being asked for.
        task: name of the scene's task.
        seed: index of the scene within the split.
        own_goal: the skill instruction that the scene was made for.
        goal: the one that holds.
        proposal: what the next step will carry out; None while there is none.
        steps: what was done so far.
        note: the last thing worth telling the person.
        pictures: camera name, or "viewer" for the human's -> (H, W, 3) uint8.
        folder: where the episode is written.
        video: of the episode, once it is over.
    """

    version: int = 0
    phase: Phase = "over"
    running: bool = False
    task: str = ""
    seed: int = 0
    own_goal: str = ""
    goal: str = ""
    proposal: Choice | None = None
    steps: tuple[DrivenStep, ...] = ()
    note: str = ""
    pictures: Mapping[str, np.ndarray] = field(default_factory=dict)
    folder: Path | None = None
    video: Path | None = None

    @property
    def held(self) -> str | None:
        """The person's correction that stands, None if there is none."""
        return self.proposal.instruction if self.proposal is not None and self.proposal.source == "person" else None
