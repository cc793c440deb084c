"""Annotating recordings: keyframes from states, instructions from a person."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_recordings import calibration_of, fake_demonstrations
from fakes_trajectories import KINDS, SEGMENTS
from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import find, needs_all
from lerobot_llakey.datasets import annotate as module
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.errors import FileInTheWayError, LlakeyError
from lerobot_llakey.geometry import DOWN

JOINTS = slice(8, 15)
TEXTS = ["move to the top of the cup", "grasp the cup"]


def two_moves() -> np.ndarray:
    """States of a robot that moves, rests, closes its gripper and rests, at 10 fps."""
    states = np.zeros((26, len(schema.SIM_STATE_NAMES)), dtype=np.float32)
    ramp = np.clip(np.arange(26) / 10, 0, 1)
    states[:, 0] = 0.3 + 0.2 * ramp
    states[:, schema.QUATERNION] = (1, 0, 0, 0)
    states[:, JOINTS] = ramp[:, None]
    states[:, schema.GRIPPER] = 1 - 0.5 * np.clip((np.arange(26) - 15) / 3, 0, 1)
    return states


def recordings(root: Path, dtype: str = "image") -> LeRobotDataset:
    """Two episodes as a person records them: pictures, state, and an action of the robot's own."""
    camera = schema.image_key("front")
    features = {
        schema.STATE: schema.vector(schema.SIM_STATE_NAMES),
        schema.ACTION: {"dtype": "float32", "shape": (8,), "names": None},
        camera: {"dtype": dtype, "shape": (32, 32, 3), "names": ["height", "width", "channels"]},
    }
    dataset = LeRobotDataset.create("me/recordings", 10, features, root=root, use_videos=dtype == "video")
    for _ in range(2):
        for index, state in enumerate(two_moves()):
            picture = np.full((32, 32, 3), index, dtype=np.uint8)
            action = np.full(8, 7, dtype=np.float32)
            dataset.add_frame(
                {schema.STATE: state, schema.ACTION: action, camera: picture, schema.TASK: "take the cup"}
            )
        dataset.save_episode(parallel_encoding=False)
    dataset.finalize()
    return LeRobotDataset("me/recordings", root=root)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return recordings(tmp_path_factory.mktemp("annotate") / "recordings")


@pytest.fixture(scope="module")
def found(source: LeRobotDataset) -> list[FoundKeyframes]:
    return find_keyframes(source)


def test_keyframes_are_found_in_every_episode(found: list[FoundKeyframes]) -> None:
    assert [episode.keyframes for episode in found] == [[10, 25]] * 2
    assert found[1].episode == 1 and found[1].task == "take the cup"
    assert found[0].seconds(1) == (1.0, 2.5)


def test_the_copy_carries_the_contracts_columns_and_the_source_stays(
    source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path
) -> None:
    copy = annotate(source, found, {0: TEXTS, 1: TEXTS}, tmp_path / "copy", "me/demonstrations")
    assert len(copy) == len(source)
    for index in (0, 9, 10, 25, 26, 40):
        item, original = copy[index], source[index]
        segment = 0 if index % 26 < 10 else 1
        assert item[schema.INSTRUCTION] == TEXTS[segment]
        np.testing.assert_allclose(item[schema.ACTION][0], 0.5)
        assert item[schema.ACTION][schema.GRIPPER] == (1 - segment)
        assert item[schema.ACTION].shape == (schema.ACTION_DIM,)
        assert item[schema.NEXT_KEYFRAME] == (10, 25)[segment]
        assert item[schema.IS_KEYFRAME] == (index % 26 in (10, 25))
        assert item[schema.EPISODE_SEED] == -1
        np.testing.assert_array_equal(item[schema.image_key("front")], original[schema.image_key("front")])
        np.testing.assert_array_equal(item[schema.STATE], original[schema.STATE])
        speed = float(index % 26 < 10)
        np.testing.assert_allclose(item[schema.VELOCITY][:7], speed, atol=1e-5)
        assert original[schema.ACTION].shape == (8,)
    assert copy.meta.stats is not None and copy.meta.stats[schema.ACTION]["mean"].shape == (schema.ACTION_DIM,)


def test_velocities_that_were_recorded_are_kept(tmp_path: Path) -> None:
    source = recordings(tmp_path / "recordings")
    feature = schema.vector(schema.SIM_VELOCITY_NAMES)
    measured = pa.array([[0.25] * 8] * 26, pa.list_(pa.float32(), 8))
    rewrite(
        source.root, lambda table: {schema.VELOCITY: measured.take(table["frame_index"])}, {schema.VELOCITY: feature}
    )
    source = LeRobotDataset(source.repo_id, root=source.root)
    copy = annotate(source, find_keyframes(source), {0: TEXTS, 1: TEXTS}, tmp_path / "copy", "me/demonstrations")
    assert {float(copy[index][schema.VELOCITY][0]) for index in (0, 10, 30)} == {0.25}


def test_videos_are_copied(tmp_path: Path) -> None:
    source = recordings(tmp_path / "recordings", "video")
    copy = annotate(source, find_keyframes(source), {0: TEXTS, 1: TEXTS}, tmp_path / "copy", "me/demonstrations")
    key = schema.image_key("front")
    np.testing.assert_array_equal(copy[30][key], source[30][key])
    assert copy[30][schema.INSTRUCTION] == TEXTS[0]


def test_too_few_instructions_are_refused_before_anything_is_written(
    source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match="2 instructions for episode 1"):
        annotate(source, found, {0: TEXTS, 1: TEXTS[:1]}, tmp_path / "copy", "me/demonstrations")
    assert not (tmp_path / "copy").exists()


def test_an_existing_folder_is_refused(source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path) -> None:
    with pytest.raises(FileExistsError, match="choose another one"):
        annotate(source, found, {0: TEXTS, 1: TEXTS}, source.root, "me/demonstrations")


def test_a_state_without_names_is_refused(tmp_path: Path) -> None:
    features = {schema.STATE: {"dtype": "float32", "shape": (6,), "names": None}}
    other = LeRobotDataset.create("me/other", 10, features, root=tmp_path / "other", use_videos=False)
    with pytest.raises(LlakeyError, match=r"a name for each of the 6 numbers.*got none"):
        find_keyframes(other)


def test_instructions_outside_the_grammar_are_refused_before_anything_is_written(
    source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path
) -> None:
    texts = {0: ["approach the cup", TEXTS[1]], 1: [TEXTS[0], "seize it"]}
    with pytest.raises(LlakeyError, match=r"got 2 outside it: 'approach the cup' \(episode 0, segment 0; .*'seize it'"):
        annotate(source, found, texts, tmp_path / "copy", "me/demonstrations")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("point", ["rewrite"])
def test_a_run_that_was_killed_leaves_nothing_that_looks_done_and_the_next_one_goes_through(
    point: str, source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(module, point, killed)
        patch.setattr("lerobot_llakey.folders.remove", lambda path: None)  # a killed process cleans up nothing
        with pytest.raises(KeyboardInterrupt):
            annotate(source, found, {0: TEXTS, 1: TEXTS}, tmp_path / "copy", "me/demonstrations")
    assert not (tmp_path / "copy").exists()
    copy = annotate(source, found, {0: TEXTS, 1: TEXTS}, tmp_path / "copy", "me/demonstrations")
    assert copy[0][schema.INSTRUCTION] == TEXTS[0]
    assert [path.name for path in tmp_path.iterdir()] == ["copy"]


def test_a_source_that_stands_in_the_way_is_left_alone(source: LeRobotDataset, found: list[FoundKeyframes]) -> None:
    with pytest.raises(FileInTheWayError):
        annotate(source, found, {0: TEXTS, 1: TEXTS}, source.root, source.repo_id)
    assert source[0][schema.ACTION].shape == (8,)


@pytest.mark.parametrize(
    ("columns", "change", "message"),
    [
        (JOINTS, lambda values: np.rad2deg(values), "radians.*got 17.19.*degrees"),
        (schema.POSITION, lambda values: values * 1000, "metres.*millimetres"),
        (schema.GRIPPER, lambda values: values * 100, "opening from 0.*gripper_range"),
        (schema.GRIPPER, lambda values: values * 0.08, "as in metres; give --gripper_range=.0,0.08"),
        (schema.QUATERNION, lambda values: values * 0, "unit quaternions.*norm 0"),
        (schema.POSITION, lambda values: values * np.nan, "finite"),
    ],
)
def test_recordings_in_other_units_are_refused(tmp_path: Path, columns, change, message: str) -> None:
    states = two_moves()
    states[:, columns] = change(states[:, columns])
    features = {
        schema.STATE: schema.vector(schema.SIM_STATE_NAMES),
    }
    dataset = LeRobotDataset.create("me/other", 10, features, root=tmp_path / "other", use_videos=False)
    for state in states:
        dataset.add_frame({schema.STATE: state, schema.TASK: "take the cup"})
    dataset.save_episode()
    dataset.finalize()
    with pytest.raises(LlakeyError, match=message):
        find_keyframes(LeRobotDataset("me/other", root=tmp_path / "other"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_of_any_arm_becomes_demonstrations(kind: str, tmp_path: Path) -> None:
    copy = fake_demonstrations(tmp_path, kind, scale=0.05)
    arm, names = KINDS[kind], tuple(copy.features[schema.STATE]["names"])
    assert names[:7] == schema.POSE_NAMES
    assert ("gripper_opening" in names) == (kind != "hand_alone")
    joints = [name for name in arm.state if name in arm.action and name != "jaw" and name not in schema.POSE_NAMES]
    assert list(names[8:]) == joints
    assert set(schema.cameras_of(copy.features, depth=True)) == set(arm.cameras)
    rows = copy.hf_dataset.with_format("numpy")[:]
    states, episodes = np.stack(rows[schema.STATE]), np.array(rows["episode_index"])
    for episode in range(2):
        part = states[episodes == episode]
        assert np.linalg.norm(np.diff(part[:, 3:7], axis=0), axis=1).max() < 0.2
        assert part[0, 3:7] @ DOWN > 0
    keyframes = np.flatnonzero(rows[schema.IS_KEYFRAME])
    assert len(keyframes) == 2 * SEGMENTS
    expected = [True] * 3 if kind == "hand_alone" else [True, False, False]
    starts = [0, *keyframes[:2], keyframes[2] + 1, *keyframes[3:5]]
    assert [bool(np.stack(rows[schema.ACTION])[row, schema.GRIPPER]) for row in starts] == 2 * expected
    # The hand goes to the ball, whose place was recorded in another way: as a rotation vector, or with w first.
    reached = np.stack(rows[schema.ACTION])[[starts[1], starts[4]], 2]
    assert np.allclose(reached, 0.08, atol=0.005)
    for camera in arm.cameras:
        known = calibration_of(kind, camera, 0.05)
        item = copy[len(copy) // 2]
        np.testing.assert_allclose(item[schema.intrinsics_key(camera)], known[0], rtol=1e-6)
        np.testing.assert_allclose(item[schema.extrinsics_key(camera)], known[1], atol=1e-6)
    found = find(copy.meta, needs_all(copy.features))
    assert found == []


def test_chosen_keyframes_are_taken_as_they_are(source: LeRobotDataset, found: list[FoundKeyframes]) -> None:
    last = found[0].keyframes[-1]
    again = find_keyframes(source, given={0: [last, 3]})
    assert again[0].keyframes == [3, last]
    assert again[1].keyframes == found[1].keyframes
