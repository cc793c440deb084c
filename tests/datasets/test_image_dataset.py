"""Writing datasets of small pictures: read by LeRobot as they were written."""

from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_action, fake_frame
from lerobot_llakey import schema
from lerobot_llakey.datasets.demonstrations import sim_features
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter


def frames(count: int, task: str = "lift the red ball") -> list[dict[str, object]]:
    rng = np.random.default_rng(count)
    made = []
    for index in range(count):
        frame = {key: value for key, value in fake_frame(rng).items() if not key.startswith("_")}
        frame |= {
            schema.VELOCITY: np.full(len(schema.SIM_VELOCITY_NAMES), 0.1 * index, dtype=np.float32),
            schema.ACTION: fake_action(np.array([0.4, 0.0, 0.1 * index]), gripper_open=True),
            schema.INSTRUCTION: f"grasp ball {index}",
            schema.PREVIOUS_INSTRUCTION: "",
            schema.STEP: np.zeros(1, dtype=np.float32),
            schema.IS_KEYFRAME: np.array([index == count - 1]),
            schema.KEYFRAME_INDEX: np.array([0]),
            schema.NEXT_KEYFRAME: np.array([count - 1]),
            schema.EPISODE_SEED: np.array([7]),
            schema.EPISODE_VARIATION: np.array([0]),
            schema.EPISODE_SEQUENCE: np.array([0]),
            schema.EPISODE_TASK: "lift",
            schema.EPISODE_EVENT: "drop" if index else "",
            schema.TASK: task,
        }
        made.append(frame)
    return made


def test_what_is_written_is_read(tmp_path: Path) -> None:
    episodes = [frames(3), frames(5, "drop it")]
    with ImageDatasetWriter("local/x", tmp_path / "x", 10, sim_features(32, "image"), "panda") as writer:
        for episode in episodes:
            writer.add_episode(episode)
    dataset = LeRobotDataset("local/x", root=tmp_path / "x")
    assert (len(dataset), dataset.num_episodes, dataset.meta.robot_type) == (8, 2, "panda")
    for index, frame in enumerate([*episodes[0], *episodes[1]]):
        item = dataset[index]
        for key in sim_features(32, "image"):
            if isinstance(frame[key], str):
                assert item[key] == frame[key]
            elif key.endswith("_depth"):
                np.testing.assert_array_equal(item[key].numpy(), frame[key].astype(np.float32).transpose(2, 0, 1))
            elif key.startswith("observation.images"):
                np.testing.assert_allclose(item[key].numpy() * 255, frame[key].transpose(2, 0, 1), atol=1e-3)
            else:
                np.testing.assert_array_equal(item[key].numpy().reshape(frame[key].shape), frame[key])
        assert item[schema.TASK] == frame[schema.TASK]
        assert item["frame_index"] == index - 3 * (index >= 3)


def test_statistics_are_in_lerobots_units(tmp_path: Path) -> None:
    with ImageDatasetWriter("local/x", tmp_path / "x", 10, sim_features(32, "image")) as writer:
        writer.add_episode(frames(4))
    stats = LeRobotDataset("local/x", root=tmp_path / "x").meta.stats
    assert stats is not None
    rgb, depth = stats[schema.image_key("front")], stats[schema.depth_key("front")]
    assert rgb["mean"].shape == (3, 1, 1) and 0.3 < rgb["mean"].mean() < 0.7
    assert depth["max"].shape == (1, 1, 1) and depth["max"].max() > 500
    assert stats[schema.ACTION]["mean"].shape == (schema.ACTION_DIM,)


def test_a_frame_that_does_not_fit_and_an_empty_episode_are_refused(tmp_path: Path) -> None:
    with ImageDatasetWriter("local/x", tmp_path / "x", 10, sim_features(32, "image")) as writer:
        with pytest.raises(ValueError, match="got none"):
            writer.add_episode([])
        bad = frames(1)
        del bad[0][schema.ACTION]
        with pytest.raises(ValueError, match="Missing features"):
            writer.add_episode(bad)
        writer.add_episode(frames(2))
    assert len(LeRobotDataset("local/x", root=tmp_path / "x")) == 2


def test_an_existing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileExistsError):
        ImageDatasetWriter("local/x", tmp_path, 10, sim_features(32, "image"))
