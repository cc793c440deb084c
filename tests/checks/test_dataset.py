"""A dataset that is wrong in one way is refused, naming the column; a sound one passes."""

import copy
import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata

from fakes_wrong import NAMES, WRONG, misnoted_dataset, wrong_dataset
from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import Needs, check_dataset, find, needs_all
from lerobot_llakey.errors import LlakeyError


def opened(root: Path) -> LeRobotDatasetMetadata:
    return LeRobotDatasetMetadata("local/checked", root=root)


@pytest.fixture(scope="module")
def meta_of(sound: Path) -> Callable[[Path], LeRobotDatasetMetadata]:
    """The metadata of a dataset whose rows alone differ from the sound one's: LeRobot takes a second to read it."""
    meta = opened(sound)

    def of(root: Path) -> LeRobotDatasetMetadata:
        other = copy.copy(meta)
        other.__dict__.pop("_llakey_checked", None)
        other.root = root
        return other

    return of


def test_a_sound_dataset_passes(sound: Path) -> None:
    meta = opened(sound)
    assert find(meta, needs_all(meta.features)) == []


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_dataset_is_refused_with_its_column(
    name: str, sound: Path, tmp_path: Path, meta_of: Callable[[Path], LeRobotDatasetMetadata]
) -> None:
    column, change = WRONG[name]
    meta = meta_of(wrong_dataset(sound, tmp_path / "wrong", change))
    with pytest.raises(LlakeyError, match=r"^Expected .* got .*; ") as refusal:
        check_dataset(meta, needs_all(meta.features))
    refused = {finding.column for finding in find(meta, needs_all(meta.features)) if finding.certain}
    assert column in refused, str(refusal.value)
    assert "local/checked" in str(refusal.value)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_noted_wrongly_is_refused(name: str, sound: Path, tmp_path: Path) -> None:
    column, notes = NAMES[name]
    meta = opened(misnoted_dataset(sound, tmp_path / "wrong", column, notes))
    with pytest.raises(LlakeyError, match=column):
        check_dataset(meta, needs_all(meta.features))


def test_a_refusal_names_episode_and_frame(sound: Path, tmp_path: Path) -> None:
    def change(rows: dict[str, np.ndarray]) -> None:
        rows[schema.STATE][8, 0] = np.nan

    meta = opened(wrong_dataset(sound, tmp_path / "wrong", change))
    with pytest.raises(LlakeyError, match="nan at episode 1, frame 2;"):
        check_dataset(meta, needs_all(meta.features))


def test_what_is_not_read_may_be_wrong(sound: Path, tmp_path: Path) -> None:
    _, change = WRONG["extrinsics identity"]
    meta = opened(wrong_dataset(sound, tmp_path / "wrong", change))
    check_dataset(meta, Needs(frozenset({schema.TASK, schema.INSTRUCTION}), depth=False, workspace=None))
    with pytest.raises(LlakeyError, match=schema.extrinsics_key("front")):
        check_dataset(meta, needs_all(meta.features))


def test_a_camera_that_is_not_read_may_be_wrong(sound: Path, tmp_path: Path) -> None:
    _, change = WRONG["extrinsics identity"]
    meta = opened(wrong_dataset(sound, tmp_path / "wrong", change))
    check_dataset(meta, Needs(frozenset({schema.STATE, schema.ACTION}), cameras=("wrist", "left_shoulder")))
    with pytest.raises(LlakeyError, match=r"camera_extrinsics\.front"):
        check_dataset(meta, Needs(frozenset({schema.STATE, schema.ACTION}), cameras=("wrist", "front")))


def test_depth_without_calibration_is_warned_of(sound: Path, tmp_path: Path) -> None:
    meta = opened(sound)
    meta.info.features = {key: one for key, one in meta.features.items() if key != schema.extrinsics_key("wrist")}
    found = find(meta, needs_all(meta.features))
    assert [(one.column, one.certain) for one in found] == [(schema.depth_key("wrist"), False)]


def test_depth_of_another_size_than_the_colours_is_refused(sound: Path, tmp_path: Path) -> None:
    key = schema.depth_key("wrist")
    meta = opened(misnoted_dataset(sound, tmp_path / "wrong", key, {"shape": [8, 16, 1]}))
    with pytest.raises(LlakeyError, match=f"16x16 pixels, in {key}.*16x8"):
        check_dataset(meta, needs_all(meta.features))


def test_a_workspace_may_be_wider(sound: Path, tmp_path: Path) -> None:
    def change(rows: dict[str, np.ndarray]) -> None:
        rows[schema.STATE][:, 1] += 0.6
        rows[schema.ACTION][:, 1] += 0.6

    meta = opened(wrong_dataset(sound, tmp_path / "moved", change))
    with pytest.raises(LlakeyError, match=r"widen policy\.workspace"):
        check_dataset(meta, Needs(frozenset({schema.ACTION}), depth=False, workspace=schema.WORKSPACE))
    check_dataset(meta, Needs(frozenset({schema.ACTION}), depth=False))
    wide = ((0.0, 1.0), (-1.5, 1.5), (-0.05, 0.95))
    check_dataset(meta, Needs(frozenset({schema.ACTION}), depth=False, workspace=wide))


@pytest.mark.parametrize(
    ("weight", "refused"), [(np.nan, True), (-1.0, True), (np.inf, True), (0.0, True), (2.0, False)]
)
def test_weights_that_train_nothing_are_refused(weight: float, refused: bool, sound: Path, tmp_path: Path) -> None:
    def change(rows: dict[str, np.ndarray]) -> None:
        rows[schema.STEP] = np.full(len(rows[schema.STEP]), weight)  # stands for a column of weights

    meta = opened(wrong_dataset(sound, tmp_path / "weighed", change))
    needs = Needs(frozenset({schema.STEP}), depth=False, weight_key=schema.STEP)
    found = [one for one in find(meta, needs) if one.column == schema.STEP and one.certain]
    assert bool(found) == refused


def test_depth_that_comes_in_metres_is_told_by_its_statistics(sound: Path) -> None:
    meta = opened(sound)
    meta.rescale_depth_stats("m")
    with pytest.raises(LlakeyError, match="depth_output_unit"):
        check_dataset(meta, needs_all(meta.features))


def test_black_pictures_are_told_by_their_statistics(sound: Path) -> None:
    meta = opened(sound)
    key = schema.image_key("wrist")
    meta.stats[key] = {name: np.zeros_like(value) for name, value in meta.stats[key].items()}
    with pytest.raises(LlakeyError, match=f"{key}.*0 in every pixel"):
        check_dataset(meta, needs_all(meta.features))


def test_a_check_that_passed_is_not_made_again(sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    meta = opened(sound)
    both = Needs(frozenset({schema.STATE}), depth=False) | needs_all(meta.features)
    check_dataset(meta, both)
    monkeypatch.setattr("lerobot_llakey.checks.dataset.find", lambda *_: pytest.fail("read again"))
    check_dataset(meta, Needs(frozenset({schema.STATE, schema.TASK}), depth=False))


def test_what_is_likely_wrong_is_logged(sound: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    def change(rows: dict[str, np.ndarray]) -> None:
        rows[schema.STATE][:, 9] = 7.0

    meta = opened(wrong_dataset(sound, tmp_path / "wound", change))
    with caplog.at_level(logging.WARNING):
        check_dataset(meta, needs_all(meta.features))
    assert "radians" in caplog.text


def test_a_task_that_is_empty_is_refused(sound: Path) -> None:
    meta = opened(sound)
    meta.tasks = meta.tasks.rename(index={meta.tasks.index[0]: " "})
    with pytest.raises(LlakeyError, match="task"):
        check_dataset(meta, needs_all(meta.features))
