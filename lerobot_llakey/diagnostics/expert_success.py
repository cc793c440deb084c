"""How well the experts do on unseen scenes, and whether their keyframes are found again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.diagnostics.simulations import simulation_of
from lerobot_llakey.parallel import run_jobs
from lerobot_llakey.sim.perturbations.registry import check_disturbance
from lerobot_llakey.sim.recorder import record
from lerobot_llakey.sim.tasks import task_classes

_CHUNK = 10


@dataclass(frozen=True)
class Trial:
    """One episode of an expert.

    Attributes:
        task: its name.
        seed: scene seed.
        variation: of the task.
        sequence: action sequence of the task.
        success: whether the oracle was satisfied.
        keyframes_match: whether the discovered keyframes are the waypoints.
        actions: number of waypoints.
        failures: why the arm did not move, where it did not.
        struck: whether the disturbance that was asked for struck.
    """

    task: str
    seed: int
    variation: int
    sequence: int
    success: bool
    keyframes_match: bool
    actions: int
    failures: tuple[str, ...]
    struck: bool = False


def run_trials(task: str, split: str, indices: Sequence[int], disturbance: str = "") -> list[Trial]:
    """Let a task's expert act in some scenes of a split, disturbed where asked; variations take turns."""
    simulation = simulation_of(task)
    trials = []
    for index in indices:
        seed, variation = schema.scene_seed(split, index), index % simulation.task.variations
        episode = record(simulation, seed, variation, disturbance=disturbance or None)
        trials.append(
            Trial(
                task=task,
                seed=episode.seed,
                variation=episode.variation,
                sequence=episode.sequence,
                success=episode.success,
                keyframes_match=episode.keyframes_match,
                actions=len(episode.waypoints),
                failures=tuple(episode.failures),
                struck=bool(episode.interruptions),
            )
        )
    return trials


def evaluate_experts(
    tasks: Sequence[str], num_episodes: int, split: str = "test", num_workers: int = 0, disturbance: str = ""
) -> list[Trial]:
    """Run every task's expert.

    Args:
        tasks: their names.
        num_episodes: for each task.
        split: of the scene seeds.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.
        disturbance: what disturbs each episode, out of DISTURBANCES; nothing where empty.

    Returns:
        All trials, by task and seed.

    Raises:
        LlakeyError: if the split or the disturbance is unknown.
    """
    schema.scene_seed(split, num_episodes)
    check_disturbance(disturbance)
    starts = range(0, num_episodes, _CHUNK)
    jobs = [
        (task, split, range(start, min(start + _CHUNK, num_episodes)), disturbance)
        for start in starts
        for task in tasks
    ]
    trials: list[Trial] = []
    with tqdm(total=len(tasks) * num_episodes, unit="episode", desc="expert") as bar:
        for found in run_jobs(run_trials, jobs, num_workers):
            trials.extend(found)
            bar.set_postfix(success=f"{sum(trial.success for trial in trials) / len(trials):.1%}", refresh=False)
            bar.update(len(found))
    return sorted(trials, key=lambda trial: (tasks.index(trial.task), trial.seed))


def summarise(trials: Iterable[Trial]) -> dict[str, dict[str, Any]]:
    """Figures by task.

    Returns:
        For each task: episodes; in how many a disturbance struck, and the share of those that were solved; success and
        keyframes_match as shares (the latter of the successful episodes); variations and sequences that were met, of
        how many; mean number of actions; reasons of failure; seeds of the episodes that failed or whose keyframes do
        not match.
    """
    grouped: dict[str, list[Trial]] = {}
    for trial in trials:
        grouped.setdefault(trial.task, []).append(trial)
    return {task: _summary(task, found) for task, found in grouped.items()}


def _summary(task: str, trials: list[Trial]) -> dict[str, Any]:
    done = [trial for trial in trials if trial.success]
    kind = task_classes()[task]
    sequences = Counter(trial.sequence for trial in trials)
    struck = [trial for trial in trials if trial.struck]
    return {
        "episodes": len(trials),
        "struck": len(struck),
        "recovered": sum(trial.success for trial in struck) / max(1, len(struck)),
        "success": len(done) / len(trials),
        "keyframes_match": sum(trial.keyframes_match for trial in done) / max(1, len(done)),
        "variations_met": len({trial.variation for trial in trials}),
        "variations": kind.variations,
        "sequences_met": len(sequences),
        "sequences": kind.sequences,
        "success_by_sequence": {
            str(sequence): sum(trial.success for trial in trials if trial.sequence == sequence) / count
            for sequence, count in sorted(sequences.items())
        },
        "actions": sum(trial.actions for trial in trials) / len(trials),
        "failures": dict(Counter(reason for trial in trials for reason in trial.failures)),
        "failed_seeds": [trial.seed for trial in trials if not trial.success],
        "mismatched_seeds": [trial.seed for trial in done if not trial.keyframes_match],
    }


def table(summary: dict[str, dict[str, Any]]) -> str:
    """The figures as text, one line a task; with what was recovered from where a disturbance struck."""
    columns: dict[str, Callable[[dict[str, Any]], str]] = {
        "episodes": lambda row: str(row["episodes"]),
        "success": lambda row: f"{row['success']:.1%}",
        "keyframes": lambda row: f"{row['keyframes_match']:.1%}",
        "variations": lambda row: f"{row['variations_met']}/{row['variations']}",
        "sequences": lambda row: f"{row['sequences_met']}/{row['sequences']}",
        "actions": lambda row: f"{row['actions']:.1f}",
        "no path": lambda row: str(sum(row["failures"].values())),
    }
    if any(row["struck"] for row in summary.values()):
        columns["struck"] = lambda row: str(row["struck"])
        columns["recovered"] = lambda row: f"{row['recovered']:.1%}"
    rows = [("task", *columns), *((task, *(show(row) for show in columns.values())) for task, row in summary.items())]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)
