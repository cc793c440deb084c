"""Collecting demonstrations, keysteps or both from the simulator's experts, in several processes.

The episodes are numbered, each with its task, variation and scene seeds fixed beforehand, and collected in *parts* of a
few dozen: finished LeRobotDatasets in a folder beside the final one, which appear there under their names only once
they are whole. At the end the parts are merged in order. So a run that was stopped in any way goes on with the parts
that are missing, and the result does not depend on the number of processes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from pathlib import Path

from tqdm import tqdm

from lerobot_llakey.bounds import require_count
from lerobot_llakey.datasets.collect_part import collect_part
from lerobot_llakey.datasets.demonstrations import check_depth
from lerobot_llakey.datasets.parts import growing
from lerobot_llakey.datasets.places import check_space
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.parallel import PROCESSES, count_workers, run_jobs, tell
from lerobot_llakey.shards import WHOLE, Shard

_PART_EPISODES = 48
"""At most so many episodes are lost when a process is killed."""
MOST_WORKERS = 256


def quieten() -> None:
    """Silence the chatter of the libraries that write datasets."""
    import av.logging
    import datasets

    datasets.disable_progress_bars()
    av.logging.set_libav_level(av.logging.ERROR)
    logging.getLogger("lerobot").setLevel(logging.ERROR)


def _collect_part(settings: CollectSettings, kinds: tuple[str, ...], start: int, stop: int, folder: Path) -> None:
    quieten()
    collect_part(settings, kinds, start, stop, folder, tell)


def collect(
    settings: CollectSettings,
    targets: Targets,
    num_workers: int = 0,
    progress: Callable[[int, int], None] | None = None,
    shard: Shard = WHOLE,
    engine: str = PROCESSES,
) -> dict[str, int]:
    """Collect until every target holds all episodes, going on with what is there.

    Args:
        settings: what to collect.
        targets: where to.
        num_workers: processes; one for each CPU core where 0, none but this one where 1.
        progress: called with the episodes (kept, discarded) since the last call; a progress bar where None.
        shard: of the episodes; ``merge_shards`` makes of all shards what one run would have made.
        engine: as in :func:`lerobot_llakey.parallel.run_jobs`; a cluster's machines must share the targets' folders.

    Returns:
        Number of episodes discarded by reason, over all runs for these targets.

    Raises:
        LlakeyError: if no target is given, one cannot be written to or was begun with other settings, or an expert
            fails too often, or a cluster's machines do not share the folders.
    """
    named = targets.named()
    if not named:
        raise LlakeyError("Expected demonstrations, keysteps or both to be collected, got neither; give one a folder.")
    require_count("--num_workers", num_workers, 0, MOST_WORKERS)
    quieten()
    workers = count_workers(num_workers, engine)
    ours, of = shard.of(len(settings)), shard.recorded(len(settings))
    with growing(settings.resumable() | of, len(ours), named, part_size(len(ours), workers)) as growth:
        planned = list(plan_parts(ours.start + growth.begin, ours.stop, growth.part_size, growth.parts))
        folders = [folder for _, _, folder in planned]
        to_make = set(growth.missing(folders))
        missing = [part for part in planned if part[2] in to_make]
        episodes = sum(stop - start for start, stop, _ in missing)
        if "demonstrations" in named:
            older = [growth.targets["demonstrations"][0]] if growth.begin else []
            check_depth([*older, *(folder / "demonstrations" for folder in folders if folder not in to_make)])
        check_space(growth.targets, episodes, len(ours), settings.image_size)
        with _Bar(len(ours), len(ours) - episodes, progress) as bar:
            jobs = [(settings, tuple(named), *part) for part in missing]
            for _ in run_jobs(_collect_part, jobs, num_workers, bar.add, engine):
                pass
        growth.require(folders)
        return growth.finish(folders)


def part_size(episodes: int, workers: int) -> int:
    """Episodes a part: so many that few datasets are merged, so few that all processes have work until near the end."""
    return max(4, min(_PART_EPISODES, -(-episodes // (4 * workers))))


def plan_parts(begin: int, end: int, size: int, parts: Path) -> Iterator[tuple[int, int, Path]]:
    """First episode, the one after the last, and the folder of each part of the episodes [begin, end)."""
    for start in range(begin, end, size):
        stop = min(start + size, end)
        yield start, stop, parts / f"{start:07d}-{stop:07d}"


class _Bar:
    """Progress of episodes, as a bar or to a callback."""

    def __init__(self, total: int, done: int, callback: Callable[[int, int], None] | None) -> None:
        self._callback, self._discarded = callback, 0
        self._bar = tqdm(total=total, initial=done, unit="episode", desc="collect", disable=callback is not None)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def add(self, discarded: int) -> None:
        """Another episode is kept, and so many were discarded for it."""
        self._discarded += discarded
        if self._callback is not None:
            self._callback(1, discarded)
        self._bar.set_postfix(discarded=self._discarded, refresh=False)
        self._bar.update()
