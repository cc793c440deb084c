"""Annotating recordings: keyframes from states, instructions from a person."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from lerobot.datasets.language import LANGUAGE_PERSISTENT
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets import annotate as module
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.errors import FileInTheWayError, LlakeyError

TEXTS = ["move to the top of the cup", "grasp the cup"]


def two_moves() -> np.ndarray:
    """States of a robot that moves, rests, closes its gripper and rests, at 10 fps."""
    states = np.zeros((26, schema.STATE_DIM), dtype=np.float32)
    ramp = np.clip(np.arange(26) / 10, 0, 1)
    states[:, 0] = 0.3 + 0.2 * ramp
    states[:, schema.QUATERNION] = (1, 0, 0, 0)
    states[:, schema.JOINTS] = ramp[:, None]
    states[:, schema.GRIPPER] = 1 - 0.5 * np.clip((np.arange(26) - 15) / 3, 0, 1)
    return states


def recordings(root: Path, dtype: str = "image") -> LeRobotDataset:
    """Two episodes as a person records them: pictures, state, and an action of the robot's own."""
    camera = schema.image_key("front")
    features = {
        schema.STATE: {"dtype": "float32", "shape": (schema.STATE_DIM,), "names": list(schema.STATE_NAMES)},
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
        assert [row["content"] for row in item[LANGUAGE_PERSISTENT]] == TEXTS
        np.testing.assert_array_equal(item[schema.image_key("front")], original[schema.image_key("front")])
        np.testing.assert_array_equal(item[schema.STATE], original[schema.STATE])
        speed = float(index % 26 < 10)
        np.testing.assert_allclose(item[schema.VELOCITY][schema.ARM_VELOCITY], speed, atol=1e-5)
        assert original[schema.ACTION].shape == (8,)
    assert copy.meta.stats is not None and copy.meta.stats[schema.ACTION]["mean"].shape == (schema.ACTION_DIM,)


def test_velocities_that_were_recorded_are_kept(tmp_path: Path) -> None:
    source = recordings(tmp_path / "recordings")
    feature = schema.keystep_features(cameras=())[schema.VELOCITY]
    measured = pa.array([[0.25] * schema.VELOCITY_DIM] * 26, pa.list_(pa.float32(), schema.VELOCITY_DIM))
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


def test_a_state_of_another_shape_is_named(tmp_path: Path) -> None:
    features = {schema.STATE: {"dtype": "float32", "shape": (6,), "names": None}}
    other = LeRobotDataset.create("me/other", 10, features, root=tmp_path / "other", use_videos=False)
    with pytest.raises(ValueError, match="gripper_opening"):
        find_keyframes(other)


def test_instructions_outside_the_grammar_are_refused_before_anything_is_written(
    source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path
) -> None:
    texts = {0: ["approach the cup", TEXTS[1]], 1: [TEXTS[0], "seize it"]}
    with pytest.raises(LlakeyError, match=r"got 2 outside it: 'approach the cup' \(episode 0, segment 0; .*'seize it'"):
        annotate(source, found, texts, tmp_path / "copy", "me/demonstrations")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("point", ["rewrite", "write_language", "write_stats"])
def test_a_run_that_was_killed_leaves_nothing_that_looks_done_and_the_next_one_goes_through(
    point: str, source: LeRobotDataset, found: list[FoundKeyframes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object) -> None:
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
        (schema.JOINTS, lambda values: np.rad2deg(values), "radians.*got 11.46.*degrees"),
        (schema.POSITION, lambda values: values * 1000, "metres.*millimetres"),
        (schema.GRIPPER, lambda values: values * 100, "opening from 0.*percent"),
        (schema.GRIPPER, lambda values: values * 0.08, "as in metres"),
        (schema.QUATERNION, lambda values: values * 0, "unit quaternions.*norm 0"),
        (schema.POSITION, lambda values: values * np.nan, "finite"),
    ],
)
def test_recordings_in_other_units_are_refused(tmp_path: Path, columns, change, message: str) -> None:
    states = two_moves()
    states[:, columns] = change(states[:, columns])
    features = {
        schema.STATE: {"dtype": "float32", "shape": (schema.STATE_DIM,), "names": list(schema.STATE_NAMES)},
    }
    dataset = LeRobotDataset.create("me/other", 10, features, root=tmp_path / "other", use_videos=False)
    for state in states:
        dataset.add_frame({schema.STATE: state, schema.TASK: "take the cup"})
    dataset.save_episode()
    dataset.finalize()
    with pytest.raises(LlakeyError, match=message):
        find_keyframes(LeRobotDataset("me/other", root=tmp_path / "other"))
