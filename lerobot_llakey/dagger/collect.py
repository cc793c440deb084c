"""Collecting the states that a policy visits, in several processes; a run that was stopped goes on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from tqdm import tqdm

from lerobot_llakey.bounds import require_count
from lerobot_llakey.dagger.episode import visited_frames
from lerobot_llakey.dagger.plan import DaggerSettings
from lerobot_llakey.datasets.collect import MOST_WORKERS, quieten
from lerobot_llakey.datasets.demonstrations import ROBOT_TYPE, sim_features
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter
from lerobot_llakey.datasets.parts import DISCARDED, growing, new_part
from lerobot_llakey.datasets.places import check_space
from lerobot_llakey.parallel import kept, run_jobs
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.recorder import FPS

_KIND = "keysteps"
_PART_EPISODES = 10
"""At most so many episodes are lost when a run is killed."""


def collect(settings: DaggerSettings, root: Path, repo_id: str, num_workers: int = 0) -> None:
    """Write a keysteps dataset of the states that a policy visits, going on with what is there.

    Args:
        settings: what to collect.
        root: folder of the dataset.
        repo_id: its name.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.

    Raises:
        LlakeyError: if the folder was begun with other settings.
        MissingFileError: if there is no such policy.
    """
    require_count("--num_workers", num_workers, 0, MOST_WORKERS)
    with growing(settings.resumable(), len(settings), {_KIND: (root, repo_id)}, _PART_EPISODES) as growth:
        spans = [] if growth.begin else list(settings.parts(growth.part_size))
        planned = {growth.parts / f"{task}-{start:06d}": (task, start, stop) for task, start, stop in spans}
        missing = [(settings, *planned[folder], folder) for folder in growth.missing(list(planned))]
        episodes = sum(stop - start for _, _, start, stop, _ in missing)
        check_space(growth.targets, episodes, len(settings), settings.image_size)
        with tqdm(total=len(settings), initial=len(settings) - episodes, unit="episode", desc="dagger") as bar:
            for made in run_jobs(_collect_part, missing, num_workers):
                bar.update(made)
        growth.finish(list(planned))


def _actors(path: str) -> tuple[Agent, Agent]:
    """The policy as it is, and with the expert's instructions."""
    return Agent.load(path), Agent.load(path, oracle=True)


def _collect_part(settings: DaggerSettings, task: str, start: int, stop: int, folder: Path) -> int:
    """Write some episodes of a task as a finished dataset; how many there were."""
    quieten()
    env = LlakeySimEnv(
        task,
        settings.split,
        settings.image_size,
        episode_length=settings.max_steps,
        oracle_instructions=True,
        disturbance=settings.disturbance,
    )
    features = sim_features(settings.image_size, "image")
    with new_part(folder) as temporary:
        with ImageDatasetWriter("local/part", temporary / _KIND, FPS, features, ROBOT_TYPE) as writer:
            for number in range(start, stop):
                scene = settings.first_seed + number
                rng = np.random.default_rng((scene, len(task)))
                actor = kept(_actors, settings.policy_path)[number % 2]
                if frames := visited_frames(env, actor, scene, rng, settings.expert_share):
                    writer.add_episode(frames)
        env.close()
        (temporary / DISCARDED).write_text(json.dumps({}))
    return stop - start
