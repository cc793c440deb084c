"""Annotating recordings: keyframes from states, instructions from a person."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from lerobot.datasets.language import LANGUAGE_PERSISTENT
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets import annotate as module
from lerobot_llakey.datasets.annotate import FoundKeyframes, annotate, find_keyframes, read_instructions
from lerobot_llakey.datasets.rewrite import rewrite

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
    with pytest.raises(FileExistsError, match="choose a new folder"):
        annotate(source, found, {0: TEXTS, 1: TEXTS}, tmp_path, "me/demonstrations")


def test_a_state_of_another_shape_is_named(tmp_path: Path) -> None:
    features = {schema.STATE: {"dtype": "float32", "shape": (6,), "names": None}}
    other = LeRobotDataset.create("me/other", 10, features, root=tmp_path / "other", use_videos=False)
    with pytest.raises(ValueError, match="gripper_opening"):
        find_keyframes(other)


def test_a_filled_in_template_is_read_again(found: list[FoundKeyframes], tmp_path: Path) -> None:
    path = tmp_path / "instructions.csv"
    module.write_template(found, path)
    lines = path.read_text().splitlines()
    assert lines[0] == "episode,segment,from_second,to_second,instruction"
    assert lines[2] == "0,1,1.0,2.5,"
    filled = [lines[0], *(line + TEXTS[index % 2] for index, line in enumerate(lines[1:]))]
    path.write_text("\n".join(filled))
    assert read_instructions(path) == {0: TEXTS, 1: TEXTS}


def test_json_instructions_are_read(tmp_path: Path) -> None:
    path = tmp_path / "instructions.json"
    path.write_text(json.dumps({"0": TEXTS, "3": TEXTS[:1]}))
    assert read_instructions(path) == {0: TEXTS, 3: TEXTS[:1]}


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", "episode,instruction\n0,grasp the cup\n", "columns episode, segment and instruction"),
        ("b.csv", "episode,segment,instruction\n0,1,grasp the cup\n", "segment 0 of episode 0"),
        ("c.json", '["grasp the cup"]', "something else"),
    ],
)
def test_instruction_files_of_another_form_are_named(name: str, content: str, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(ValueError, match=message):
        read_instructions(tmp_path / name)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="--template"):
        read_instructions(tmp_path / "none.csv")


def test_typed_instructions_are_offered_again_for_the_next_episode(found: list[FoundKeyframes]) -> None:
    prompts: list[str] = []
    answers = iter([*TEXTS, "", ""])

    def ask(prompt: str) -> str:
        prompts.append(prompt)
        return next(answers)

    assert module.ask_instructions(found, ask) == {0: TEXTS, 1: TEXTS}
    assert prompts[0] == "episode 0 (take the cup), 0.0 to 1.0 s: "
    assert prompts[3] == "episode 1 (take the cup), 1.0 to 2.5 s [grasp the cup]: "
