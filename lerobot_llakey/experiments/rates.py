"""How fast this machine is at what the stages are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Rates:
    """Seconds that things take here, in one process; zeros where nothing was measured.

    Attributes:
        demonstration: one episode collected as demonstration.
        keysteps: the keysteps of one demonstration drawn.
        keystep_episode: one episode collected as keysteps at once.
        start: of a training, before its first step.
        step: one training step, by the training's name.
        action: one step of an episode, command and action policy together, the simulator's part in it.
        answer: one answer of a command policy.
        video: one action in a video.
        cores: processes that share episodes.
    """

    demonstration: float = 0.0
    keysteps: float = 0.0
    keystep_episode: float = 0.0
    start: float = 0.0
    step: Mapping[str, float] = field(default_factory=dict)
    action: float = 0.0
    answer: float = 0.0
    video: float = 0.0
    cores: int = 1
