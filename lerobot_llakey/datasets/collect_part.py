"""One part of a collection: a few dozen episodes, recorded, rendered and written as finished datasets."""

from __future__ import annotations

import functools
import json
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from lerobot_llakey.datasets.demonstrations import ROBOT_TYPE, DemonstrationWriter, frames_of, keystep_rng, sim_features
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter
from lerobot_llakey.datasets.parts import DISCARDED, new_part
from lerobot_llakey.datasets.plan import ATTEMPTS, CollectSettings
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.recorder import Episode, record
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task


class _Stages:
    """The simulations of one process, built when first needed: each has its own OpenGL context."""

    def __init__(self, image_size: int) -> None:
        self.image_size = image_size
        self._made: dict[str, tuple[Simulation, CameraRig]] = {}

    def get(self, task: str) -> tuple[Simulation, CameraRig]:
        if task not in self._made:
            simulation = Simulation(make_task(task))
            self._made[task] = simulation, CameraRig(simulation.world.model, self.image_size)
        return self._made[task]


@functools.lru_cache(maxsize=1)
def _stages(image_size: int) -> _Stages:
    return _Stages(image_size)


def good_episode(settings: CollectSettings, index: int, simulation: Simulation) -> tuple[Episode, Counter[str]]:
    """Record the ``index``-th episode, trying its seeds in turn, and count what was discarded.

    Raises:
        LlakeyError: if all its seeds fail.
    """
    task, number = settings.slot(index)
    variation = number % simulation.task.variations
    discarded: Counter[str] = Counter()
    for attempt in range(ATTEMPTS):
        episode = record(
            simulation, settings.seed(number, attempt), variation, settings.fps, settings.disturbance(number)
        )
        if episode.usable:
            return episode, discarded
        discarded[f"{task}: " + ("keyframes differ from the waypoints" if episode.success else "not done")] += 1
    raise LlakeyError(
        f"Expected the expert of {task} to do variation {variation} in one of {ATTEMPTS} scenes, got none from seed "
        f"{settings.seed(number, 0)} on; run llakey expert to see what fails."
    )


def collect_part(
    settings: CollectSettings,
    kinds: tuple[str, ...],
    start: int,
    stop: int,
    folder: Path,
    done: Callable[[int], None],
) -> None:
    """Write the episodes [start, stop) as finished datasets under ``folder``; ``done`` hears what each threw away.

    Where the part is there already, as where a process was killed before it could say so, that is all.
    """
    if (folder / DISCARDED).exists():
        for _ in range(start, stop):
            done(0)
        return
    stages = _stages(settings.image_size)
    discarded: Counter[str] = Counter()
    size, balance = settings.image_size, settings.balance
    with new_part(folder) as temporary:
        with ExitStack() as stack:
            demonstrations = keysteps = None
            if "demonstrations" in kinds:
                demonstrations = stack.enter_context(
                    DemonstrationWriter(
                        "local/part", temporary / "demonstrations", settings.fps, sim_features(size, "video")
                    )
                )
            if "keysteps" in kinds:
                features = sim_features(size, "image") | balance.features()
                keysteps = stack.enter_context(
                    ImageDatasetWriter("local/part", temporary / "keysteps", settings.fps, features, ROBOT_TYPE)
                )
            for index in range(start, stop):
                simulation, rig = stages.get(settings.slot(index)[0])
                episode, bad = good_episode(settings, index, simulation)
                discarded += bad
                samples = []
                if keysteps is not None:
                    samples = balance.select(episode.keyframes, len(episode), keystep_rng(episode))
                frames = frames_of(
                    simulation, rig, episode, range(len(episode)) if demonstrations is not None else samples
                )
                if demonstrations is not None:
                    demonstrations.add_episode(frames)
                if keysteps is not None:
                    taken = frames if demonstrations is None else [frames[i] for i in samples]
                    weighed = [balance.columns(i, episode.keyframes) for i in samples]
                    keysteps.add_episode([frame | extra for frame, extra in zip(taken, weighed, strict=True)])
                done(sum(bad.values()))
        (temporary / DISCARDED).write_text(json.dumps(discarded))
