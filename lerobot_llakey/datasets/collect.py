"""Collecting demonstrations, keysteps or both from the simulator's experts, in several processes.

The episodes are numbered, each with its task, variation and scene seeds fixed beforehand, and collected in *parts* of a
few dozen: finished LeRobotDatasets in a folder beside the final one, which appear there under their names only once
they are whole. At the end the parts are merged in order. So a run that was stopped in any way goes on with the parts
that are missing, and the result does not depend on the number of processes.
"""

from __future__ import annotations

import json
import logging
import os
import queue
import shutil
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.datasets.demonstrations import ROBOT_TYPE, DemonstrationWriter, frames_of, keystep_rng
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter
from lerobot_llakey.datasets.keysteps import SamplingMode, select
from lerobot_llakey.datasets.parts import PARTS_SUFFIX, begin_parts, finish
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.recorder import Episode, record
from lerobot_llakey.sim.tasks import make_task
from lerobot_llakey.sim.world import World

ATTEMPTS = 10
"""Scenes tried for an episode before giving up: an expert that fails this often in a row is broken."""
_PART_EPISODES = 48
"""At most so many episodes are lost when a process is killed."""
_POLL_SECONDS = 0.2


@dataclass(frozen=True)
class CollectSettings:
    """What to collect; the same settings always give the same episodes.

    Attributes:
        tasks: names of tasks.
        num_episodes: for each task; their variations take turns.
        split: of the scene seeds: train, val or test.
        first_seed: index into the split of the first episode; each episode reserves ATTEMPTS seeds.
        image_size: pixels of height and width.
        fps: frames a second.
        keystep_mode: how keysteps are drawn.
    """

    tasks: tuple[str, ...]
    num_episodes: int
    split: str = "train"
    first_seed: int = 0
    image_size: int = schema.IMAGE_SIZE
    fps: int = 10
    keystep_mode: SamplingMode = "thin"

    def __len__(self) -> int:
        """Number of episodes over all tasks."""
        return len(self.tasks) * self.num_episodes

    def slot(self, index: int) -> tuple[str, int]:
        """Task of the ``index``-th episode and its number among the episodes of that task."""
        return self.tasks[index % len(self.tasks)], index // len(self.tasks)

    def seed(self, number: int, attempt: int) -> int:
        """Scene seed of an attempt at the ``number``-th episode of a task."""
        return schema.scene_seed(self.split, self.first_seed + number * ATTEMPTS + attempt)

    def resumable(self) -> dict[str, Any]:
        """What must stay the same when a run goes on or is extended."""
        return {key: value for key, value in json.loads(json.dumps(asdict(self))).items() if key != "num_episodes"}


@dataclass(frozen=True)
class Targets:
    """Where the datasets go; at least one of them.

    Attributes:
        demonstrations: folder of the demonstrations dataset, or None.
        keysteps: folder of the keysteps dataset, or None.
        demonstrations_id: repo id of the demonstrations.
        keysteps_id: repo id of the keysteps.
    """

    demonstrations: Path | None
    keysteps: Path | None
    demonstrations_id: str = "local/demonstrations"
    keysteps_id: str = "local/keysteps"

    def named(self) -> dict[str, tuple[Path, str]]:
        """Folder and repo id by kind."""
        kinds = {
            "demonstrations": (self.demonstrations, self.demonstrations_id),
            "keysteps": (self.keysteps, self.keysteps_id),
        }
        return {kind: (root, repo_id) for kind, (root, repo_id) in kinds.items() if root is not None}


class _Stages:
    """The worlds of one process, built when first needed: each has its own OpenGL context."""

    def __init__(self, image_size: int) -> None:
        self.image_size = image_size
        self._made: dict[str, tuple[World, CameraRig]] = {}

    def get(self, task: str) -> tuple[World, CameraRig]:
        if task not in self._made:
            world = World(make_task(task))
            self._made[task] = world, CameraRig(world.model, self.image_size)
        return self._made[task]


_stages: _Stages | None = None
_progress: Any = None


def _start_worker(progress: Any) -> None:
    global _progress
    import torch

    torch.set_num_threads(1)
    quieten()
    _progress = progress
    parent = parent_process()
    if parent is not None:
        # A killed parent must not leave workers behind that write into the next run's folder.
        threading.Thread(target=_die_with, args=(parent,), daemon=True).start()


def _die_with(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


def quieten() -> None:
    """Silence the chatter of the libraries that write datasets."""
    import av.logging
    import datasets

    datasets.disable_progress_bars()
    av.logging.set_libav_level(av.logging.ERROR)
    logging.getLogger("lerobot").setLevel(logging.ERROR)


def good_episode(settings: CollectSettings, index: int, world: World) -> tuple[Episode, Counter[str]]:
    """Record the ``index``-th episode, trying its seeds in turn, and count what was thrown away.

    Raises:
        RuntimeError: if all its seeds fail.
    """
    task, number = settings.slot(index)
    variation = number % world.task.variations
    thrown: Counter[str] = Counter()
    for attempt in range(ATTEMPTS):
        episode = record(world, settings.seed(number, attempt), variation, settings.fps)
        if episode.usable:
            return episode, thrown
        thrown[f"{task}: " + ("keyframes differ from the waypoints" if episode.success else "not done")] += 1
    raise RuntimeError(
        f"Expected the expert of {task} to do variation {variation} in one of {ATTEMPTS} scenes, got none from seed "
        f"{settings.seed(number, 0)} on; run llakey expert to see what fails."
    )


def _collect_part_in_worker(
    settings: CollectSettings, kinds: tuple[str, ...], start: int, stop: int, folder: Path
) -> None:
    _collect_part(settings, kinds, start, stop, folder, _progress.put)


def _collect_part(
    settings: CollectSettings,
    kinds: tuple[str, ...],
    start: int,
    stop: int,
    folder: Path,
    done: Callable[[int], None],
) -> None:
    """Write the episodes [start, stop) as finished datasets under ``folder``; ``done`` hears what each threw away."""
    global _stages
    if _stages is None or _stages.image_size != settings.image_size:
        _stages = _Stages(settings.image_size)
    temporary = folder.with_name(f"unfinished-{folder.name}-{os.getpid()}")
    thrown: Counter[str] = Counter()
    size = settings.image_size
    with ExitStack() as stack:
        demonstrations = keysteps = None
        if "demonstrations" in kinds:
            demonstrations = stack.enter_context(
                DemonstrationWriter("local/part", temporary / "demonstrations", settings.fps, size)
            )
        if "keysteps" in kinds:
            features = schema.keystep_features(size, size)
            keysteps = stack.enter_context(
                ImageDatasetWriter("local/part", temporary / "keysteps", settings.fps, features, ROBOT_TYPE)
            )
        for index in range(start, stop):
            world, rig = _stages.get(settings.slot(index)[0])
            episode, bad = good_episode(settings, index, world)
            thrown += bad
            samples = []
            if keysteps is not None:
                samples = select(episode.keyframes, len(episode), rng=keystep_rng(episode), mode=settings.keystep_mode)
            frames = frames_of(world, rig, episode, range(len(episode)) if demonstrations is not None else samples)
            if demonstrations is not None:
                demonstrations.add_episode(frames)
            if keysteps is not None:
                keysteps.add_episode([frames[i] for i in samples] if demonstrations is not None else frames)
            done(sum(bad.values()))
    (temporary / "thrown.json").write_text(json.dumps(thrown))
    temporary.replace(folder)


def collect(
    settings: CollectSettings,
    targets: Targets,
    num_workers: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, int]:
    """Collect until every target holds all episodes, going on with what is there.

    Args:
        settings: what to collect.
        targets: where to.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.
        progress: called with the episodes (kept, thrown away) since the last call; a progress bar where None.

    Returns:
        Number of episodes thrown away by reason, over all runs for these targets.

    Raises:
        ValueError: if no target is given, or a target was begun with other settings.
        RuntimeError: if an expert fails too often.
    """
    named = targets.named()
    if not named:
        raise ValueError("Expected demonstrations, keysteps or both to be collected, got neither; give one a folder.")
    parts = Path(f"{next(iter(named.values()))[0]}{PARTS_SUFFIX}")
    roots = {kind: root for kind, (root, _) in named.items()}
    quieten()
    workers = num_workers or os.cpu_count() or 1
    begin, size = begin_parts(settings.resumable(), roots, parts, _part_size(len(settings), workers))
    planned = list(_plan(begin, len(settings), size, parts))
    missing = [part for part in planned if not part[2].exists()]
    for folder in parts.iterdir():
        if folder.is_dir() and folder not in {part[2] for part in planned}:
            shutil.rmtree(folder)
    with _Bar(len(settings), len(settings) - sum(stop - start for start, stop, _ in missing), progress) as bar:
        if missing:
            run = _run_here if workers == 1 else _run_in_processes
            run(settings, tuple(named), missing, workers, bar)
    return finish(settings.resumable(), len(settings), named, [part[2] for part in planned], parts)


def _part_size(episodes: int, workers: int) -> int:
    """Large enough that few datasets are merged, small enough that all processes have work until near the end."""
    return max(4, min(_PART_EPISODES, -(-episodes // (4 * workers))))


def _plan(begin: int, end: int, size: int, parts: Path) -> Iterator[tuple[int, int, Path]]:
    for start in range(begin, end, size):
        stop = min(start + size, end)
        yield start, stop, parts / f"{start:07d}-{stop:07d}"


def _run_here(
    settings: CollectSettings, kinds: tuple[str, ...], missing: list[tuple[int, int, Path]], _: int, bar: _Bar
) -> None:
    for part in missing:
        _collect_part(settings, kinds, *part, lambda thrown: bar.add(1, thrown))


def _run_in_processes(
    settings: CollectSettings, kinds: tuple[str, ...], missing: list[tuple[int, int, Path]], workers: int, bar: _Bar
) -> None:
    context = get_context("spawn")
    done = context.Queue()
    with ProcessPoolExecutor(min(workers, len(missing)), context, _start_worker, (done,)) as pool:
        futures = [pool.submit(_collect_part_in_worker, settings, kinds, *part) for part in missing]
        finished = threading.Event()

        def watch() -> None:
            while not finished.is_set() or not done.empty():
                try:
                    bar.add(1, done.get(timeout=_POLL_SECONDS))
                except queue.Empty:
                    continue

        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        try:
            for future in as_completed(futures):
                future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        finally:
            finished.set()
            watcher.join()


class _Bar:
    """Progress of episodes, as a bar or to a callback."""

    def __init__(self, total: int, done: int, callback: Callable[[int, int], None] | None) -> None:
        self._callback, self._thrown = callback, 0
        self._bar = tqdm(total=total, initial=done, unit="episode", desc="collect", disable=callback is not None)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def add(self, kept: int, thrown: int) -> None:
        self._thrown += thrown
        if self._callback is not None:
            self._callback(kept, thrown)
        self._bar.set_postfix(thrown_away=self._thrown, refresh=False)
        self._bar.update(kept)
