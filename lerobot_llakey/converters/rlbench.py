"""From RLBench's and PerAct's demonstrations to a dataset of demonstrations of the data contract.

All numbers are read, and every episode is given its keyframes and instructions, before anything is written; then the
episodes are written in parts, so that a run that was stopped goes on with those that are missing.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.converters.rlbench_episode import FPS, Numbers, read_numbers
from lerobot_llakey.converters.rlbench_files import EpisodeFolder
from lerobot_llakey.converters.rlbench_keyframes import keypoints
from lerobot_llakey.datasets.collect import part_size, plan_parts, quieten
from lerobot_llakey.datasets.demonstrations import DemonstrationWriter
from lerobot_llakey.datasets.parts import DISCARDED, growing
from lerobot_llakey.datasets.plan import IMAGE_SIZES
from lerobot_llakey.datasets.sequences import TaskInstructions, shown
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.labels import label
from lerobot_llakey.parallel import run_jobs, tell
from lerobot_llakey.sim.cameras import RGBD
from lerobot_llakey.sim.recorder import frame_columns

_SHOWN = 3
"""Episodes that an error names."""
_KIND = "demonstrations"


@dataclass(frozen=True)
class PlannedEpisode:
    """What becomes of one demonstration.

    Attributes:
        folder: where it lies.
        skill: its skill instruction.
        variation: of the task.
        sequence: which of the task's sequences of instructions fits.
        keyframes: frames; the last one is the episode's.
        instructions: one a keyframe.
    """

    folder: EpisodeFolder
    skill: str
    variation: int
    sequence: int
    keyframes: tuple[int, ...]
    instructions: tuple[str, ...]


def plan_episodes(
    folders: Sequence[EpisodeFolder], instructions: dict[str, TaskInstructions], *, skip_unmatched: bool = False
) -> tuple[list[PlannedEpisode], list[Path]]:
    """Find keyframes and instructions of all demonstrations; reads everything but the pictures.

    Args:
        folders: of the demonstrations.
        instructions: by task.
        skip_unmatched: leave out episodes whose keyframes fit no sequence of instructions.

    Returns:
        What is to be written, and the folders of what is left out.

    Raises:
        LlakeyError: if a file is missing or broken, a task has no instructions, no sequence fits an episode that is
            not to be left out, or pictures differ in size.
    """
    if unknown := sorted({folder.task for folder in folders} - set(instructions)):
        raise LlakeyError(
            f"Expected tasks with instructions ({', '.join(instructions)}), got {', '.join(unknown)}; add them in a "
            "file for --instructions, or pick others by --tasks."
        )
    sizes = _sizes(folders[0])
    planned: list[PlannedEpisode] = []
    unmatched: list[tuple[EpisodeFolder, str]] = []
    for folder in tqdm(folders, desc="read", unit="episode"):
        if _sizes(folder) != sizes:
            raise LlakeyError(
                f"Expected pictures of one size a camera ({sizes}), got {_sizes(folder)} in {folder.path}; convert "
                "them into datasets of their own."
            )
        numbers = read_numbers(folder, folder.observations())
        found = keypoints(numbers.gripper_open, numbers.velocities[:, :-1])
        opened = numbers.gripper_open[found].tolist()
        skills = folder.skills()
        if (fit := instructions[folder.task].fitting(skills, opened)) is None:
            unmatched.append((folder, shown(opened)))
            continue
        sequence, texts = fit
        planned.append(PlannedEpisode(folder, skills[0], folder.variation(), sequence, tuple(found), tuple(texts)))
    if unmatched and not (skip_unmatched and planned):
        listed = "; ".join(
            f"{pattern} in {folder.path} ({folder.task}: {instructions[folder.task].patterns()})"
            for folder, pattern in unmatched[:_SHOWN]
        )
        raise LlakeyError(
            f"Expected keyframes whose gripper (o open, c closed) fits a sequence of instructions, got "
            f"{len(unmatched)} of {len(folders)} episodes that do not: {listed}; add sequences in a file for "
            "--instructions" + (", or leave them out with --skip_unmatched=true." if planned else ".")
        )
    return planned, [folder.path for folder, _ in unmatched]


def convert(
    episodes: Sequence[PlannedEpisode], root: Path, repo_id: str, grammar: Grammar, num_workers: int = 0
) -> None:
    """Write demonstrations, going on where an earlier run with the same episodes was stopped.

    Args:
        episodes: in the order of the dataset.
        root: folder of the dataset.
        repo_id: its name.
        grammar: of the instructions; the dataset keeps it.
        num_workers: processes; one for each CPU core where 0.

    Raises:
        LlakeyError: if a picture is broken, or the folder comes from something else or cannot be written to.
    """
    quieten()
    workers = num_workers or os.cpu_count() or 1
    told = [[*episode.folder.path.parts[-4:], *episode.instructions] for episode in episodes]
    settings = {
        "format": "rlbench",
        "tasks": sorted({episode.folder.task for episode in episodes}),
        "cameras": list(episodes[0].folder.cameras),
        "digest": hashlib.sha256(json.dumps(told).encode()).hexdigest(),
    }
    targets = {_KIND: (root, repo_id)}
    with growing(settings, len(episodes), targets, part_size(len(episodes), workers)) as growth:
        planned = list(plan_parts(growth.begin, len(episodes), growth.part_size, growth.parts))
        folders = [folder for _, _, folder in planned]
        to_make = set(growth.missing(folders))
        jobs = [(episodes[start:stop], grammar, folder) for start, stop, folder in planned if folder in to_make]
        missing = sum(len(part) for part, _, _ in jobs)
        with tqdm(total=len(episodes), initial=len(episodes) - missing, desc="convert", unit="episode") as bar:
            for _ in run_jobs(_convert_part, jobs, workers, bar.update):
                pass
        growth.finish(folders)


def _convert_part(episodes: Sequence[PlannedEpisode], grammar: Grammar, folder: Path) -> None:
    """Write some episodes as a finished dataset under ``folder``."""
    quieten()
    temporary = folder.with_name(f"unfinished-{folder.name}-{os.getpid()}")
    features = schema.dataset_features(_sizes(episodes[0].folder)) | schema.label_features(grammar.to_data())
    with DemonstrationWriter("local/part", temporary / _KIND, FPS, features) as writer:
        for episode in episodes:
            writer.add_episode(_frames(episode))
            tell(1)
    (temporary / DISCARDED).write_text("{}")
    temporary.replace(folder)


def _frames(episode: PlannedEpisode) -> Iterator[dict[str, Any]]:
    folder, keyframes, sizes = episode.folder, list(episode.keyframes), _sizes(episode.folder)
    numbers = read_numbers(folder, folder.observations())
    labels = label(
        numbers.states,
        keyframes,
        episode.instructions,
        # As PerAct, which asks the frame before: there the path that ends at the keyframe was planned.
        [bool(numbers.ignore_collision[frame - 1]) for frame in keyframes],
        numbers.gripper_open[keyframes].tolist(),
    )
    origin = {
        schema.EPISODE_SEED: np.array([-1]),
        schema.EPISODE_VARIATION: np.array([episode.variation]),
        schema.EPISODE_SEQUENCE: np.array([episode.sequence]),
        schema.EPISODE_TASK: folder.task,
    }
    for step in range(len(numbers.states)):
        robot = {schema.STATE: numbers.states[step], schema.VELOCITY: numbers.velocities[step]}
        yield {
            **frame_columns(_pictures(folder, numbers, sizes, step)),
            **labels.row(step),
            **origin,
            **robot,
            schema.TASK: episode.skill,
        }


def _pictures(folder: EpisodeFolder, numbers: Numbers, sizes: Mapping[str, schema.Size], step: int) -> dict[str, RGBD]:
    pictures = {}
    for camera, track in numbers.cameras.items():
        colours = folder.colours(camera, step)
        depth = folder.depth(camera, step, float(track.near[step]), float(track.far[step]))
        if not colours.shape[:2] == depth.shape == sizes[camera]:
            raise LlakeyError(
                f"Expected pictures of {sizes[camera]} pixels of {camera} in {folder.path}, got {colours.shape[:2]} "
                f"and {depth.shape} at time step {step}; fetch the episode anew."
            )
        pictures[camera] = RGBD(colours, depth * 1000, track.intrinsics[step], track.extrinsics[step])
    return pictures


def _sizes(folder: EpisodeFolder) -> dict[str, schema.Size]:
    sizes = {camera: folder.size(camera) for camera in folder.cameras}
    smallest, largest = IMAGE_SIZES
    for camera, size in sizes.items():
        if any(pixels % 2 or not smallest <= pixels <= largest for pixels in size):
            raise LlakeyError(
                f"Expected pictures of an even height and width from {smallest} to {largest} pixels, as videos need, "
                f"got {size} of {camera} in {folder.path}; leave that camera out by --cameras."
            )
    return sizes
