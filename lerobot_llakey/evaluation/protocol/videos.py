"""Videos of some episodes of a table, made by doing their recorded actions again."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import Record
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.work import make_env, named, single_threaded
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.rollout.replay import Replay
from lerobot_llakey.rollout.video import EpisodeVideo


def choose(records: Iterable[Record], count: int) -> list[Record]:
    """The first successes and the first failures of each row, task and disturbance, up to ``count`` of each.

    Under a disturbance only episodes that it struck are worth seeing.
    """
    chosen: list[Record] = []
    taken: dict[tuple[str, str, str, bool], int] = {}
    for record in sorted(records, key=lambda record: record.trial.key):
        trial, episode = record.trial, record.episode
        group = (trial.row, trial.task, trial.disturbance, episode.success)
        if taken.get(group, 0) < count and (episode.disturbed or not trial.disturbance):
            taken[group] = taken.get(group, 0) + 1
            chosen.append(record)
    return chosen


def video_path(folder: Path, row: Row, record: Record) -> Path:
    """Where the video of an episode lies: in its row's folder, named after the episode and its outcome."""
    trial: Trial = record.trial
    outcome = (
        "success" if record.episode.success else f"failure_{record.attribution}" if record.attribution else "failure"
    )
    parts = (trial.task, trial.disturbance, f"{trial.repeat}_{trial.episode:02d}", outcome)
    return folder / row.slug / f"{'_'.join(filter(None, parts))}.mp4"


def make_video(plan: Plan, record: Record, path: Path, detailed: bool) -> Path:
    """Write the video of a recorded episode.

    Args:
        plan: that the episode is part of.
        record: the episode.
        path: of the video.
        detailed: show the robot's detailed meshes.

    Returns:
        The path.

    Raises:
        LlakeyError: if the episode does not come out as it was recorded.
    """
    with named(record.trial), single_threaded():
        env = make_env(record.trial.task, record.trial.disturbance, plan.split, plan.max_steps, detailed)
        video, recorded = EpisodeVideo(), record.episode
        again = run_episode(env, Replay(recorded.actions, recorded.instructions), recorded.seed, [video])
        if (again.success, again.failures) != (recorded.success, recorded.failures):
            raise LlakeyError(
                f"Expected {len(recorded.actions)} actions to end as recorded (success: {recorded.success}), got "
                f"success: {again.success} after {len(again.actions)}; replay with the simulator that recorded them."
            )
        video.save(path)
        env.close()
    return path
