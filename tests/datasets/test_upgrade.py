"""Datasets of the first contract are brought to the present one, pictures and all."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lerobot.datasets.dataset_tools import delete_episodes
from lerobot.datasets.io_utils import load_stats
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_action, fake_frame
from lerobot_llakey import schema
from lerobot_llakey.datasets.demonstrations import depth_encoder, rgb_encoder
from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter
from lerobot_llakey.datasets.upgrade import upgrade
from lerobot_llakey.errors import FileInTheWayError, LlakeyError
from lerobot_llakey.geometry import canonical_quaternion, continuous_quaternions, pose_to_matrix

CAMERAS = ("wrist", "front")
SIZE, LENGTH, KEYFRAMES = 32, 6, (3, 5)
_PARTS = ("camera_intrinsics", "camera_extrinsics")


def old_features(dtype: str) -> dict[str, dict[str, Any]]:
    """What the first contract wrote."""
    new = schema.dataset_features(dict.fromkeys(CAMERAS, (SIZE, SIZE)), dtype=dtype)
    kept = {key: value for key, value in new.items() if not any(part in key for part in _PARTS)}
    texts = {f"observation.{key}": {**kept.pop(key), "info": None} for key in schema.TEXTS}
    shapes = {"observation.camera_intrinsics": (2, 3, 3), "observation.camera_extrinsics": (2, 4, 4)}
    return kept | texts | {key: {"dtype": "float32", "shape": shape, "names": None} for key, shape in shapes.items()}


def old_episode(seed: int) -> list[dict[str, Any]]:
    """Frames whose hand turns past the downward pose, where w >= 0 makes quaternions jump."""
    rng = np.random.default_rng(seed)
    scene = {key: value for key, value in fake_frame(rng, SIZE, CAMERAS).items() if not key.startswith("_")}
    intrinsics = np.tile(np.eye(3), (2, 1, 1))
    poses = np.stack([scene.pop(schema.extrinsics_key(camera)) for camera in CAMERAS])
    for matrix, camera in zip(intrinsics, CAMERAS, strict=True):
        matrix[(0, 1, 0, 1), (0, 1, 2, 2)] = scene.pop(schema.intrinsics_key(camera))
    tilts = np.linspace(-0.3, 0.4, LENGTH)
    states = np.tile(scene[schema.STATE], (LENGTH, 1))
    states[:, schema.QUATERNION] = [canonical_quaternion(np.array((1.0, 0.1, 0.0, tilt))) for tilt in tilts]
    frames = []
    for index in range(LENGTH):
        segment = int(index >= KEYFRAMES[0])
        action = fake_action(states[0, :3], gripper_open=True)
        action[schema.QUATERNION] = states[KEYFRAMES[segment], schema.QUATERNION]
        frames.append(
            scene
            | {
                "observation.camera_intrinsics": intrinsics.astype(np.float32),
                "observation.camera_extrinsics": pose_to_matrix(poses).astype(np.float32),
                "observation.instruction": f"instruction {segment}",
                "observation.previous_instruction": "" if index == 0 else "before",
                schema.STATE: states[index],
                schema.VELOCITY: np.zeros(8, np.float32),
                schema.ACTION: action,
                schema.STEP: np.array([segment], np.float32),
                schema.IS_KEYFRAME: np.array([index in KEYFRAMES]),
                schema.KEYFRAME_INDEX: np.array([segment]),
                schema.NEXT_KEYFRAME: np.array([KEYFRAMES[segment]]),
                schema.EPISODE_SEED: np.array([seed]),
                schema.EPISODE_VARIATION: np.array([0]),
                schema.EPISODE_SEQUENCE: np.array([0]),
                schema.EPISODE_TASK: "",
                schema.EPISODE_EVENT: "",
                schema.TASK: "lift the ball",
            }
        )
    return frames


def old_dataset(root: Path, kind: str) -> Path:
    """Two episodes of the first contract, as demonstrations or keysteps, which lack the last frame."""
    if kind == "keysteps":
        with ImageDatasetWriter("local/old", root, 10, old_features("image")) as writer:
            for seed in range(2):
                writer.add_episode(old_episode(seed)[:-1])
        return root
    dataset = LeRobotDataset.create(
        "local/old",
        10,
        old_features("video"),
        root=root,
        rgb_encoder=rgb_encoder(),
        depth_encoder=depth_encoder(),
    )
    for seed in range(2):
        for frame in old_episode(seed):
            dataset.add_frame(frame)
        dataset.save_episode()
    dataset.finalize()
    return root


@pytest.mark.parametrize("kind", ["keysteps", "demonstrations"])
def test_an_old_dataset_becomes_one_of_the_present_contract(kind: str, tmp_path: Path) -> None:
    old = LeRobotDataset("local/old", root=old_dataset(tmp_path / "old", kind))
    upgrade(old.root, tmp_path / "new")
    new = LeRobotDataset("local/new", root=tmp_path / "new")
    dtype = "image" if kind == "keysteps" else "video"
    assert set(schema.dataset_features(dict.fromkeys(CAMERAS, (SIZE, SIZE)), dtype=dtype)) <= set(new.features)
    assert not {"observation.camera_extrinsics", "observation.instruction"} & set(new.features)
    assert len(new) == len(old)
    for index in range(len(old)):
        before, after = old[index], new[index]
        assert after[schema.INSTRUCTION] == before["observation.instruction"]
        assert after[schema.PREVIOUS_INSTRUCTION] == before["observation.previous_instruction"]
        for place, camera in enumerate(CAMERAS):
            matrix = before["observation.camera_intrinsics"][place]
            assert after[schema.intrinsics_key(camera)].tolist() == matrix[(0, 1, 0, 1), (0, 1, 2, 2)].tolist()
            pose = after[schema.extrinsics_key(camera)]
            np.testing.assert_allclose(pose_to_matrix(pose), before["observation.camera_extrinsics"][place], atol=1e-6)
            for key in (schema.image_key(camera), schema.depth_key(camera)):
                np.testing.assert_array_equal(after[key], before[key])
    assert not (tmp_path / ".new.llakey-unfinished").exists()


@pytest.mark.parametrize("kind", ["keysteps", "demonstrations"])
def test_quaternions_jump_no_more_and_actions_have_the_sign_of_what_they_reach(kind: str, tmp_path: Path) -> None:
    old = LeRobotDataset("local/old", root=old_dataset(tmp_path / "old", kind)).hf_dataset.with_format("numpy")
    upgrade(tmp_path / "old", tmp_path / "new")
    new = LeRobotDataset("local/new", root=tmp_path / "new")
    rows = new.hf_dataset.with_format("numpy")
    count = len(rows) // 2
    for begin in (0, count):
        states, actions = (np.array(rows[key])[begin : begin + count] for key in (schema.STATE, schema.ACTION))
        was = np.array(old[schema.STATE])[begin : begin + count, schema.QUATERNION]
        assert (was[:, 3] >= 0).all() and (np.sum(was[1:] * was[:-1], axis=1) < 0).any(), "it did jump"
        quaternions = states[:, schema.QUATERNION]
        np.testing.assert_array_equal(quaternions, continuous_quaternions(was))
        assert (np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0).all() and (quaternions[:, 0] > 0).all()
        np.testing.assert_array_equal(actions[0, schema.QUATERNION], quaternions[KEYFRAMES[0]])
        assert (actions[:, schema.QUATERNION] @ np.array((1, 0, 0, 0)) > 0).all()


def test_statistics_follow_as_a_whole_and_by_episode(tmp_path: Path) -> None:
    upgrade(old_dataset(tmp_path / "old", "keysteps"), tmp_path / "new")
    new = LeRobotDataset("local/new", root=tmp_path / "new")
    numbers = {key for key, feature in new.features.items() if feature["dtype"] != "string"}
    stats = load_stats(new.root)
    assert stats is not None and set(stats) == numbers
    states = np.array(new.hf_dataset.with_format("numpy")[schema.STATE])
    np.testing.assert_allclose(stats[schema.STATE]["mean"], states.mean(axis=0), atol=1e-6)
    left = delete_episodes(new, [0], tmp_path / "left", "local/left")
    np.testing.assert_allclose(left.meta.stats[schema.STATE]["min"], states[len(states) // 2 :].min(axis=0))
    assert set(left.meta.stats) == numbers


def test_a_dataset_of_the_present_contract_and_a_place_taken_are_refused(tmp_path: Path) -> None:
    old_dataset(tmp_path / "old", "keysteps")
    upgrade(tmp_path / "old", tmp_path / "new")
    with pytest.raises(LlakeyError, match=r"first contract.*use it as it is"):
        upgrade(tmp_path / "new", tmp_path / "newer")
    with pytest.raises(FileInTheWayError):
        upgrade(tmp_path / "old", tmp_path / "new")
    assert not (tmp_path / "newer").exists()


def test_calibration_of_other_cameras_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(schema, "cameras_of", lambda features: ("front",))
    with pytest.raises(LlakeyError, match=r"1 cameras front .* got 2 matrices"):
        upgrade(old_dataset(tmp_path / "old", "keysteps"), tmp_path / "new")
