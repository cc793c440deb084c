"""One recorded episode as people look at it: its keyframes with pictures, words, gripper and cloud."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.hand import hand_columns, names_of, read_hand
from lerobot_llakey.policies.action.batch.point_cloud import fuse_views

_AROUND = 0.3
"""Metres about the keyframes' box within which the cloud is shown."""
_NEEDED = (schema.STATE, schema.ACTION, *schema.TEXTS, schema.IS_KEYFRAME)


@dataclass(frozen=True)
class Moment:
    """One frame.

    Attributes:
        frame: its index in the episode.
        seconds: since the episode's beginning.
        leads: the instruction that led to it, at a keyframe; "" elsewhere.
        next: the instruction that leads on from it.
        is_keyframe: whether it is one.
        action: (9,) the next keyframe's, see schema.ACTION_NAMES.
        hand: (8,) metres, quaternion xyzw, the gripper's opening; see schema.HAND_NAMES.
        images: RGB (H, W, 3) uint8 by camera.
        points: (M, 3) of the cloud in metres, base frame; (0, 3) without depth.
        colours: (M, 3) in 0..1.
    """

    frame: int
    seconds: float
    leads: str
    next: str
    is_keyframe: bool
    action: np.ndarray
    hand: np.ndarray
    images: dict[str, np.ndarray]
    points: np.ndarray
    colours: np.ndarray


@dataclass(frozen=True)
class Reached:
    """One keyframe, without pictures.

    Attributes:
        frame: its index in the episode.
        instruction: what led to it.
        action: (9,) the pose and the gripper's state that were reached.
    """

    frame: int
    instruction: str
    action: np.ndarray


class EpisodeLook:
    """Reads one episode of a dataset with the contract's keyframe and instruction columns.

    Args:
        dataset: demonstrations.
        episode: index of the episode.

    Attributes:
        name: of the dataset.
        episode: index of the episode.
        task: the skill instruction.
        fps: frames a second.
        keyframes: in order.
        cameras: names of those with colours.

    Raises:
        LlakeyError: if there is no such episode, or a column is missing.
    """

    def __init__(self, dataset: LeRobotDataset, episode: int) -> None:
        if lacking := [key for key in _NEEDED if key not in dataset.features]:
            raise LlakeyError(
                f"Expected demonstrations with {', '.join(lacking)}, got {dataset.repo_id} without; annotate it with "
                "llakey annotate."
            )
        if not 0 <= episode < dataset.meta.total_episodes:
            raise LlakeyError(
                f"Expected an episode from 0 to {dataset.meta.total_episodes - 1}, got {episode}; correct --episode."
            )
        self._dataset, self.name, self.episode, self.fps = dataset, dataset.repo_id, episode, dataset.fps
        wanted = [*_NEEDED, "episode_index", "task_index"]
        with reading(dataset.root, "dataset"):
            rows = dataset.hf_dataset.select_columns(wanted).with_format("numpy")[:]
            self._rows = np.flatnonzero(rows["episode_index"] == episode)
        columns = {key: np.asarray(rows[key])[self._rows] for key in wanted}
        self.task = str(dataset.meta.tasks.iloc[int(columns["task_index"][0])].name)
        self.cameras = schema.cameras_of(dataset.features)
        self._hand = hand_columns(names_of(dataset.features[schema.STATE]))
        self._deep = schema.cameras_of(dataset.features, depth=True)
        self._texts = [str(text) for text in columns[schema.INSTRUCTION]]
        actions = columns[schema.ACTION].reshape(len(self._rows), -1)
        self._marks = columns[schema.IS_KEYFRAME].reshape(-1).astype(bool)
        done = columns[schema.PREVIOUS_INSTRUCTION]
        # The frame before a keyframe leads to it; the keyframe itself leads on.
        frames = [int(frame) for frame in np.flatnonzero(self._marks)]
        if not frames or not frames[0]:
            raise LlakeyError(
                f"Expected whole episodes with keyframes after their first frame in {dataset.repo_id}, got keyframes "
                f"at {frames[:5]} of episode {episode}; look at the demonstrations in place of samples of them."
            )
        self.keyframes = [Reached(frame, str(done[frame]), actions[frame - 1]) for frame in frames]
        places = actions[:, schema.POSITION]
        self._box = torch.tensor(np.stack((places.min(axis=0) - _AROUND, places.max(axis=0) + _AROUND), axis=1))

    def __len__(self) -> int:
        """Number of frames."""
        return len(self._rows)

    def moment(self, frame: int) -> Moment:
        """Decode one frame.

        Raises:
            LlakeyError: if its pictures cannot be read.
        """
        with reading(self._dataset.root, "dataset"):
            item = self._dataset[int(self._rows[frame])]
        images = {camera: _pixels(item[schema.image_key(camera)]) for camera in self.cameras}
        points, colours = self._cloud(item)
        leads = next((reached.instruction for reached in self.keyframes if reached.frame == frame), "")
        return Moment(
            frame,
            frame / self.fps,
            leads,
            self._texts[frame],
            bool(self._marks[frame]),
            item[schema.ACTION].numpy(),
            read_hand(item[schema.STATE].numpy(), self._hand),
            images,
            points,
            colours,
        )

    def moments(self) -> Iterator[Moment]:
        """All frames in order."""
        return map(self.moment, range(len(self)))

    def _cloud(self, item: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        if not self._deep:
            return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32)
        keys = [key(camera) for camera in self._deep for key in _COLUMNS]
        cloud = fuse_views({key: item[key][None] for key in keys}, self._deep, self._box.float())
        return cloud.points.numpy(), cloud.colours.numpy()


_COLUMNS = (schema.image_key, schema.depth_key, schema.intrinsics_key, schema.extrinsics_key)


def _pixels(image: torch.Tensor) -> np.ndarray:
    pixels: np.ndarray = (image.permute(1, 2, 0).clamp(0, 1) * 255).round().byte().numpy()
    return pixels
