"""Stages of a long piece of work, each of which leaves a marker, so that a killed run goes on where it was."""

from __future__ import annotations

import json
import resource
import shutil
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.files import reading, write_whole

MARKERS = "stages"


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes:
        name: unique, also its marker's.
        title: what it does, in words.
        settings: all that its result depends on, beside the stages that it needs; plain data.
        needs: names of stages whose results it uses; they come earlier.
        produces: files and folders, removed before it is done anew.
        work: does it, going on with what an ended run left; None for a training.
        training: the training that it is, which may run beside others.
        seconds: how long it takes from its beginning, by the rates measured here.
    """

    name: str
    title: str
    settings: Mapping[str, Any]
    needs: tuple[str, ...] = ()
    produces: tuple[Path, ...] = ()
    work: Callable[[], None] | None = None
    training: Training | None = None
    seconds: Callable[[Rates], float] = field(default=lambda rates: 0.0)


@dataclass(frozen=True)
class Marker:
    """What a stage leaves.

    Attributes:
        settings: with which it was begun.
        after: for each stage that it needs, the ``run`` of that stage whose result it used.
        run: tells one run of the stage from another.
        done: whether it has ended.
        seconds: of wall-clock time, over all runs that it took.
        cpu_seconds: of all processes.
    """

    settings: dict[str, Any]
    after: dict[str, str]
    run: str
    done: bool = False
    seconds: float = 0.0
    cpu_seconds: float = 0.0


class Ledger:
    """The markers of a folder.

    Args:
        folder: where the work is done.
        stages: all of them, in order.

    Raises:
        LlakeyError: if a marker is broken.
    """

    def __init__(self, folder: Path, stages: Sequence[Stage]) -> None:
        self.folder, self.stages = folder / MARKERS, {stage.name: stage for stage in stages}
        self.markers: dict[str, Marker] = {}
        for name in self.stages:
            path = self.folder / f"{name}.json"
            if path.exists():
                with reading(path, "record of a stage"):
                    self.markers[name] = Marker(**json.loads(path.read_text()))

    def check(self) -> None:
        """Refuse settings other than those with which a stage was begun.

        Raises:
            LlakeyError: naming the stage and what has changed.
        """
        for name, marker in self.markers.items():
            changed = sorted(_changes(marker.settings, plain(self.stages[name].settings)))
            if changed:
                raise LlakeyError(
                    f"Expected the settings with which the stage {name} was begun, got a change of "
                    f"{', '.join(changed)}; restore them, give another --output_dir, or do it anew with --redo={name}."
                )

    def done(self, name: str) -> bool:
        """Whether a stage has ended, with the results of the stages before it that are there now."""
        marker = self.markers.get(name)
        if marker is None or not marker.done:
            return False
        return marker.after == self._after(name) and all(self.done(need) for need in self.stages[name].needs)

    def forget(self, names: Sequence[str]) -> list[str]:
        """Remove the results of stages and of all that follow from them, so that they are done anew.

        Raises:
            LlakeyError: if there is no such stage.
        """
        for name in names:
            if name not in self.stages:
                raise LlakeyError(f"Expected stages out of {', '.join(self.stages)}, got {name!r}; correct --redo.")
        forgotten: list[str] = []
        for name, stage in self.stages.items():
            if name in names or set(stage.needs) & set(forgotten):
                forgotten.append(name)
                self._remove(name)
        return forgotten

    def begin(self, name: str) -> None:
        """Mark a stage as begun; what was made of other results of earlier stages is removed first."""
        after, marker = self._after(name), self.markers.get(name)
        if marker is not None and (marker.after != after or marker.done):
            self._remove(name)
            marker = None
        if marker is None:
            self._write(name, Marker(plain(self.stages[name].settings), after, uuid.uuid4().hex))

    def finish(self, name: str, seconds: float, cpu_seconds: float) -> None:
        """Mark a stage as done; its time is added to that of earlier, ended runs."""
        self.spend(name, seconds, cpu_seconds)
        self._write(name, Marker(**{**vars(self.markers[name]), "done": True}))

    def spend(self, name: str, seconds: float, cpu_seconds: float) -> None:
        """Add time to a stage that goes on later."""
        marker = self.markers[name]
        spent = {"seconds": marker.seconds + seconds, "cpu_seconds": marker.cpu_seconds + cpu_seconds}
        self._write(name, Marker(**{**vars(marker), **spent}))

    def _after(self, name: str) -> dict[str, str]:
        return {need: self.markers[need].run for need in self.stages[name].needs if need in self.markers}

    def _remove(self, name: str) -> None:
        for path in self.stages[name].produces:
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        (self.folder / f"{name}.json").unlink(missing_ok=True)
        self.markers.pop(name, None)

    def _write(self, name: str, marker: Marker) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        self.markers[name] = marker
        write_whole(self.folder / f"{name}.json", json.dumps(vars(marker), indent=2))


class Clock:
    """Wall-clock and processor seconds since it was made, the latter of this process and of children that ended."""

    def __init__(self) -> None:
        self._start, self._cpu = time.perf_counter(), _cpu_seconds()

    def read(self) -> tuple[float, float]:
        """Both."""
        return time.perf_counter() - self._start, _cpu_seconds() - self._cpu


def plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as they compare once they have been JSON."""
    return dict(json.loads(json.dumps(settings, default=str)))


def _changes(before: Mapping[str, Any], now: Mapping[str, Any], prefix: str = "") -> list[str]:
    found: list[str] = []
    for key in {*before, *now}:
        old, new = before.get(key), now.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            found += _changes(old, new, f"{prefix}{key}.")
        elif old != new:
            found.append(f"{prefix}{key} (from {old} to {new})")
    return found


def _cpu_seconds() -> float:
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)
