"""How well each rule finds the keyframes of recordings that never rest, whose truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.diagnostics.segment_scores import OVERLAPS, f1, matches, segments_matched
from lerobot_llakey.diagnostics.simulations import simulation_of
from lerobot_llakey.diagnostics.teleoperation import Recording, Sensors, drive
from lerobot_llakey.geometry import Pose
from lerobot_llakey.keyframes.rules import find_by_rules, parse_rules
from lerobot_llakey.labels import keyframe_action
from lerobot_llakey.parallel import run_jobs
from lerobot_llakey.reporting.tables import markdown_table
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.simulation import Simulation

ENCODER = 2 * np.pi / 4096
"""Radians of a step of the magnetic encoders of hobby servos, as in an SO-101."""
SENSORS: dict[str, Sensors] = {
    "10 fps, 1 mrad": Sensors(10, 0.001),
    "10 fps, 3 mrad": Sensors(10, 0.003),
    "15 fps, 2 mrad": Sensors(15, 0.002),
    "30 fps, 2 mrad": Sensors(30, 0.002),
    "30 fps, encoder": Sensors(30, 0.0, ENCODER),
}
"""How recordings are taken, in turns."""
WITHIN = 3
"""Frames between a found keyframe and the true one."""


@dataclass(frozen=True)
class Score:
    """One recording, one choice of rules.

    Attributes:
        task, seed, sensors: which recording.
        rules: which rules.
        success: whether the operator did the task.
        found, truth: how many keyframes.
        right: found ones that have a true one within WITHIN frames.
        overlapping: segments that overlap a true one, by OVERLAPS.
        replayed: whether the found keyframes alone do the task again; None where they were not tried.
    """

    task: str
    seed: int
    sensors: str
    rules: str
    success: bool
    found: int
    truth: int
    right: int
    overlapping: list[int] = field(default_factory=list)
    replayed: bool | None = None


def score_episode(task: str, split: str, index: int, rules: Sequence[str], replayed: Sequence[str]) -> list[Score]:
    """Record one scene and try each choice of rules on it.

    Args:
        task: its name.
        split: of the scene seeds.
        index: of the scene; it also says which sensors and which variation.
        rules: choices of rules, as "rest+waypoints".
        replayed: those of them whose keyframes are done again.
    """
    simulation = simulation_of(task)
    sensors = list(SENSORS)[index % len(SENSORS)]
    seed = schema.scene_seed(split, index)
    recording = drive(simulation, seed, index % simulation.task.variations, SENSORS[sensors])
    scores = []
    for choice in rules:
        found = find_by_rules(recording.motion, parse_rules(choice))
        scores.append(
            Score(
                task,
                seed,
                sensors,
                choice,
                recording.success,
                len(found),
                len(recording.truth),
                matches(found, recording.truth, WITHIN),
                [segments_matched(found, recording.truth, overlap) for overlap in OVERLAPS],
                replay(simulation, recording, found) if recording.success and choice in replayed else None,
            )
        )
    return scores


def replay(simulation: Simulation, recording: Recording, keyframes: Sequence[int]) -> bool:
    """Whether the keyframes of a recording, and nothing between them, do its task again in the same scene."""
    motion = recording.motion
    simulation.reset(recording.seed, recording.variation)
    commanded = motion.commanded if motion.commanded is not None else motion.openings > 0.5
    for frame in keyframes:
        hand = np.append(motion.poses[frame], motion.openings[frame])
        action = keyframe_action(hand, bool(commanded[frame]), ignore_collision=True)
        try:
            simulation.act(Pose(action[schema.POSITION], action[schema.QUATERNION]), bool(commanded[frame]), True)
        except PlanningError:
            continue
        if simulation.success():
            return True
    return simulation.success()


def measure_rules(
    tasks: Sequence[str],
    num_episodes: int,
    rules: Sequence[str],
    replayed: Sequence[str] = (),
    split: str = "val",
    first_seed: int = 0,
    num_workers: int = 0,
) -> list[Score]:
    """Record every task and score every choice of rules.

    Args:
        tasks: their names.
        num_episodes: of each task.
        rules: choices of rules.
        replayed: those whose keyframes are done again.
        split: of the scene seeds.
        first_seed: index of the first scene.
        num_workers: processes; one for each CPU core where 0.
    """
    for choice in (*rules, *replayed):
        parse_rules(choice)
    jobs = [
        (task, split, first_seed + index, tuple(rules), tuple(replayed))
        for index in range(num_episodes)
        for task in tasks
    ]
    scores: list[Score] = []
    with tqdm(total=len(jobs), unit="episode", desc="keyframe rules") as bar:
        for found in run_jobs(score_episode, jobs, num_workers):
            scores += found
            bar.update()
    return sorted(scores, key=lambda score: (rules.index(score.rules), tasks.index(score.task), score.seed))


def summary(scores: Sequence[Score]) -> dict[str, float]:
    """Figures of one choice of rules, over the recordings in which the operator did the task."""
    done = [score for score in scores if score.success]
    found, truth = sum(score.found for score in done), sum(score.truth for score in done)
    right = sum(score.right for score in done)
    tried = [score.replayed for score in done if score.replayed is not None]
    return {
        "episodes": len(done),
        "keyframes": truth,
        "recall": right / max(1, truth),
        "false": 1 - right / max(1, found),
        **{
            f"F1@{round(100 * overlap)}": f1(sum(score.overlapping[place] for score in done), found, truth)
            for place, overlap in enumerate(OVERLAPS)
        },
        **({"replayed": sum(tried) / len(tried)} if tried else {}),
    }


def table(scores: Sequence[Score]) -> str:
    """The figures as markdown: each choice of rules over all recordings, then by how they were taken."""
    rows = []
    for choice in dict.fromkeys(score.rules for score in scores):
        mine = [score for score in scores if score.rules == choice]
        for sensors in ("all", *dict.fromkeys(score.sensors for score in mine)):
            row = summary([score for score in mine if sensors in ("all", score.sensors)])
            shares = [f"{row[name]:.1%}" for name in ("recall", "false")]
            scored = [f"{row[f'F1@{round(100 * overlap)}']:.2f}" for overlap in OVERLAPS]
            again = f"{row['replayed']:.1%}" if "replayed" in row else ""
            rows.append([choice, sensors, str(row["episodes"]), str(row["keyframes"]), *shares, *scored, again])
    names = [f"F1@{round(100 * overlap)}" for overlap in OVERLAPS]
    return markdown_table(["rules", "recorded at", "episodes", "keyframes", "found", "false", *names, "replayed"], rows)
