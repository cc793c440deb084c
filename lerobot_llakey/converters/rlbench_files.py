"""RLBench's demonstrations on disk, as RLBench and PerAct publish them.

``ROOT/TASK/all_variations/episodes/episodeN`` (PerAct), or ``ROOT/TASK/variationM/episodes/episodeN`` (RLBench), hold

- ``CAMERA_rgb/T.png`` and ``CAMERA_depth/T.png``, a pair for each time step T from 0 on,
- ``low_dim_obs.pkl``, a ``Demo`` with one ``Observation`` a time step,
- ``variation_descriptions.pkl``, a list of skill instructions, and ``variation_number.pkl``; RLBench keeps the first
  one beside ``episodes``, and tells the number by the folder's name.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from lerobot_llakey.converters.pickles import read_pickle
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading

_RGB, _DEPTH = "_rgb", "_depth"
_STEPS = float(2**24 - 1)
"""A depth picture's red, green and blue are one 24-bit number, which is this at the camera's far plane."""
_NUMBERED = re.compile(r"(episode|variation)(\d+)")


@dataclass(frozen=True)
class EpisodeFolder:
    """One demonstration on disk.

    Attributes:
        task: its name.
        path: of the folder.
        cameras: those with colours and depth, in the order of the alphabet.
    """

    task: str
    path: Path
    cameras: tuple[str, ...]

    def observations(self) -> list[Any]:
        """What was recorded without pictures, as plain containers, one a time step.

        Raises:
            LlakeyError: if it cannot be read, or there is not one pair of pictures a time step.
        """
        path = self.path / "low_dim_obs.pkl"
        content = read_pickle(path)
        found = getattr(content, "_observations", content)
        if not isinstance(found, list) or len(found) < 2 or not all(hasattr(one, "__dict__") for one in found):
            raise LlakeyError(
                f"Expected a demonstration of two time steps or more in {path}, got {type(found).__name__}; fetch it "
                "anew."
            )
        wanted = {f"{step}.png" for step in range(len(found))}
        for camera in self.cameras:
            for kind in (_RGB, _DEPTH):
                folder = self.path / f"{camera}{kind}"
                there = {file.name for file in folder.glob("*.png")}
                if there != wanted:
                    odd = sorted(wanted - there or there - wanted, key=lambda name: (len(name), name))[0]
                    raise LlakeyError(
                        f"Expected the pictures 0.png to {len(found) - 1}.png in {folder}, one a time step of "
                        f"{path.name}, got {len(there)} ({odd} is {'missing' if odd in wanted else 'one too many'}); "
                        "fetch the episode anew."
                    )
        return found

    def skills(self) -> list[str]:
        """The skill instructions, never none.

        Raises:
            MissingFileError: if no file tells them.
            LlakeyError: if it holds something else.
        """
        name = "variation_descriptions.pkl"
        places = [self.path / name, self.path.parent.parent / name]
        path = next((place for place in places if place.is_file()), places[0])
        texts = read_pickle(path)
        if not isinstance(texts, list) or not texts or not all(isinstance(text, str) and text for text in texts):
            raise LlakeyError(f"Expected a list of skill instructions in {path}, got {texts!r:.80}; fetch it anew.")
        return texts

    def variation(self) -> int:
        """The number of the task's variation.

        Raises:
            LlakeyError: if neither a file nor a folder's name tells it.
        """
        path = self.path / "variation_number.pkl"
        named = _NUMBERED.fullmatch(self.path.parent.parent.name)
        number = int(named[2]) if named and not path.is_file() else read_pickle(path)
        if not isinstance(number, int | np.integer) or number < 0:
            raise LlakeyError(f"Expected a whole number in {path}, got {number!r:.80}; fetch it anew.")
        return int(number)

    def colours(self, camera: str, step: int) -> np.ndarray:
        """(H, W, 3) uint8 RGB.

        Raises:
            LlakeyError: if the picture is broken or of another kind.
        """
        return self._pixels(f"{camera}{_RGB}", step)

    def depth(self, camera: str, step: int, near: float, far: float) -> np.ndarray:
        """Z-depth (H, W) in metres, to a 16-millionth of the way from the near plane to the far one.

        Args:
            camera: its name.
            step: time step.
            near: metres to the near plane, which is 0 in the picture.
            far: metres to the far plane.

        Raises:
            LlakeyError: if the picture is broken or of another kind.
        """
        coded = self._pixels(f"{camera}{_DEPTH}", step).astype(np.int64) @ np.array([65536, 256, 1])
        return near + coded / _STEPS * (far - near)

    def size(self, camera: str) -> tuple[int, int]:
        """Height and width of a camera's pictures; of the first, which the others must equal."""
        height, width, _ = self.colours(camera, 0).shape
        return height, width

    def _pixels(self, folder: str, step: int) -> np.ndarray:
        path = self.path / folder / f"{step}.png"
        with reading(path, "PNG picture"), Image.open(path) as picture:
            if picture.mode != "RGB":
                raise LlakeyError(
                    f"Expected {path} in red, green and blue, as RLBench saves colours and depth, got mode "
                    f"{picture.mode}; save the demonstrations with RLBench's own generator."
                )
            return np.asarray(picture)


def find_episodes(root: Path, tasks: Collection[str] = (), cameras: Sequence[str] = ()) -> list[EpisodeFolder]:
    """The demonstrations under a folder, by task, variation and number.

    Args:
        root: folder of the tasks' folders, or of one task.
        tasks: which; all where empty.
        cameras: which; all that have colours and depth where empty.

    Raises:
        MissingFileError: if there is no such folder, or a task asked for is not in it.
        LlakeyError: if there are no demonstrations, or not the cameras that were asked for, or not all alike.
    """
    if not root.is_dir():
        raise MissingFileError(f"Expected a folder of RLBench demonstrations at {root}, found none; check --source.")
    folders = [root] if _places(root) else sorted(path for path in root.iterdir() if path.is_dir() and _places(path))
    if absent := sorted(set(tasks) - {folder.name for folder in folders}):
        there = ", ".join(folder.name for folder in folders) or "none"
        raise MissingFileError(f"Expected the tasks {', '.join(absent)} in {root}, got {there}; check --tasks.")
    found = [
        EpisodeFolder(folder.name, path, _cameras(path, cameras))
        for folder in folders
        if not tasks or folder.name in tasks
        for place in _places(folder)
        for path in _numbered(place / "episodes")
    ]
    if not found:
        raise LlakeyError(
            f"Expected TASK/all_variations/episodes/episode0 and so on in {root}, found no episode; check --source."
        )
    for episode in found:
        if episode.cameras != found[0].cameras or not episode.cameras:
            raise LlakeyError(
                f"Expected colours and depth of the same cameras ({', '.join(found[0].cameras) or 'one or more'}) in "
                f"all episodes, got {', '.join(episode.cameras) or 'none'} in {episode.path}; pick some by --cameras."
            )
    return found


def _places(task: Path) -> list[Path]:
    """Where a task's episodes lie: all variations together or, where there are none, variation by variation."""
    together = task / "all_variations"
    if (together / "episodes").is_dir():
        return [together]
    return [path for path in _numbered(task, "variation") if (path / "episodes").is_dir()]


def _numbered(folder: Path, kind: str = "episode") -> list[Path]:
    matches = [(path, _NUMBERED.fullmatch(path.name)) for path in folder.iterdir() if path.is_dir()]
    return [path for _, path in sorted((int(match[2]), path) for path, match in matches if match and match[1] == kind)]


def _cameras(path: Path, wanted: Sequence[str]) -> tuple[str, ...]:
    names = {folder.name for folder in path.iterdir() if folder.is_dir()}
    found = sorted(
        name.removesuffix(_RGB) for name in names if name.endswith(_RGB) and name.removesuffix(_RGB) + _DEPTH in names
    )
    if lacking := [camera for camera in wanted if camera not in found]:
        raise LlakeyError(
            f"Expected colours and depth of {', '.join(lacking)} in {path}, got those of {', '.join(found) or 'none'}; "
            "check --cameras."
        )
    return tuple(camera for camera in found if not wanted or camera in wanted)
