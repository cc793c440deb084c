"""A catalogue of faults, each planted in a clean recording of another arm and each found by a finding that names it."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_recordings import fake_demonstrations
from fakes_wrong import Rows, read_rows, write_rows
from fuzz.datasets_on_disk import _pictures
from lerobot_llakey import schema
from lerobot_llakey.checks.checksums import CHECKSUMS
from lerobot_llakey.checks.dataset import find, needs_all
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.checks.pictures import check_pictures, draw

S, A, TEXT = schema.STATE, schema.ACTION, schema.INSTRUCTION
TOP, SIDE = schema.extrinsics_key("top"), schema.extrinsics_key("side")
K, DEPTH, RGB = schema.intrinsics_key("side"), schema.depth_key("top"), schema.image_key("top")
MARK, NEXT, SEGMENT = schema.IS_KEYFRAME, schema.NEXT_KEYFRAME, schema.KEYFRAME_INDEX
WORKSPACE: schema.Workspace = ((-1.0, 1.0), (-1.0, 1.0), (-0.2, 1.0))

Plant = Callable[[Path], Any]


def rows(change: Callable[[Rows], Any]) -> Plant:
    """A fault of the columns."""

    def plant(root: Path) -> None:
        values = read_rows(root)
        change(values)
        write_rows(root, values)

    return plant


def put(key: str, place: Any, value: Any) -> Plant:
    return rows(lambda values: values[key].__setitem__(place, value))


def times(key: str, place: Any, factor: float) -> Plant:
    return rows(lambda values: values[key].__setitem__(place, values[key][place] * factor))


def first_episode(values: Rows) -> np.ndarray:
    return np.flatnonzero(values["episode_index"] == 0)


def stand_still(values: Rows) -> None:
    place = first_episode(values)
    values[S][place] = values[S][place[0]]


def flip_signs(values: Rows) -> None:
    values[S][20:40, 3:7] *= -1


def leap(values: Rows) -> None:
    values[S][30, 0] += 0.15


def twitch(values: Rows) -> None:
    """The gripper closes and opens again on the way to a keyframe."""
    marks = np.flatnonzero(values[MARK][first_episode(values)])
    middle, width = (marks[0]) // 2, max(2, marks[0] // 6)
    values[S][middle - width : middle + width, 7] = 1 - np.round(values[S][middle, 7])


def drop_keyframe(values: Rows) -> None:
    """The keyframe at which the gripper closes is not marked: its segment and the next are one."""
    place = first_episode(values)
    marks = np.flatnonzero(values[MARK][place])
    gone = 1
    before, end = (values[SEGMENT][place] == gone), marks[gone + 1]
    values[MARK][marks[gone]] = False
    after = values[SEGMENT][place] > gone
    one = place[before]
    values[NEXT][one], values[A][one], values[TEXT][one] = end, values[A][marks[gone]], values[TEXT][marks[gone]]
    values[SEGMENT][place[after]] -= 1


def double_keyframe(values: Rows) -> None:
    """A second keyframe two frames before the first one, where the arm rests already."""
    place = first_episode(values)
    mark = np.flatnonzero(values[MARK][place])[0]
    early = mark - 1
    values[MARK][early] = True
    values[NEXT][:early] = early
    values[SEGMENT][place[early:]] += 1
    values[A][:early] = values[A][early]


def shift_grippers(values: Rows) -> None:
    """Each segment's gripper is that of the one before."""
    for episode in np.unique(values["episode_index"]):
        place = np.flatnonzero(values["episode_index"] == episode)
        grippers = [values[A][place[values[SEGMENT][place] == k][0], 7] for k in np.unique(values[SEGMENT][place])]
        for k in np.unique(values[SEGMENT][place]):
            values[A][place[values[SEGMENT][place] == k], 7] = 1 - grippers[int(k)]


def one_action_off(values: Rows) -> None:
    values[A][5, 2] += 0.01


def w_first(values: Rows) -> None:
    values[A] = values[A][:, [0, 1, 2, 6, 3, 4, 5, 7, 8]]


def shuffle(values: Rows) -> None:
    values[A] = np.random.default_rng(0).permutation(values[A])


def invert_gripper(values: Rows) -> None:
    values[S][:, 7] = 1 - values[S][:, 7]


def turn_frames(values: Rows) -> None:
    values["frame_index"] = values["frame_index"][::-1].copy()


def name_by_number(features: dict[str, Any]) -> None:
    features[S]["names"] = [f"number_{place}" for place in range(features[S]["shape"][0])]


def swap_cameras(values: Rows) -> None:
    values[TOP], values[SIDE] = values[SIDE].copy(), values[TOP].copy()


def info(change: Callable[[dict[str, Any]], Any]) -> Plant:
    def plant(root: Path) -> None:
        path = root / "meta" / "info.json"
        told = json.loads(path.read_text())
        change(told["features"])
        path.write_text(json.dumps(told))

    return plant


def stats_of_black(root: Path) -> None:
    path = root / "meta" / "stats.json"
    stats = json.loads(path.read_text())
    stats[RGB] |= {name: np.zeros_like(stats[RGB][name]).tolist() for name in ("min", "max", "mean", "std")}
    path.write_text(json.dumps(stats))


def flip_a_bit(root: Path) -> None:
    path = next((root / "data").rglob("*.parquet"))
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


FAULTS: dict[str, tuple[str, str, Plant]] = {
    "state in millimetres": (S, "position in metres", times(S, np.s_[:, :3], 1000)),
    "state with a NaN": (S, "finite numbers", put(S, (3, 0), np.nan)),
    "quaternions of length 2": (S, "unit quaternion", times(S, np.s_[:, 3:7], 2)),
    "quaternions that jump": (S, "sign does not jump", rows(flip_signs)),
    "a hand that leaps": (S, "moves steadily", rows(leap)),
    "an episode without motion": (S, "in which the hand moves", rows(stand_still)),
    "gripper 0..100": (S, "opening from 0 to 1", times(S, np.s_[:, 7], 100)),
    "gripper inverted": (S, "gripper as action", rows(invert_gripper)),

    "an unmarked change of the gripper": (MARK, "wherever the gripper", rows(twitch)),
    "a keyframe that is missing": (MARK, "wherever the gripper", rows(drop_keyframe)),
    "a keyframe twice": (A, "differ from the one before", rows(double_keyframe)),
    "grippers shifted by a keyframe": (S, "gripper as action", rows(shift_grippers)),
    "one action that is off": (A, "one action for all frames", rows(one_action_off)),
    "a target outside the workspace": (A, "inside the workspace", put(A, np.s_[5:9, 1], 1.7)),
    "actions with w first": (A, "turn at the next keyframe", rows(w_first)),
    "actions shuffled": (A, "place at the next keyframe", rows(shuffle)),
    "actions of zero": (A, "a place of the hand", times(A, np.s_[:], 0)),
    "intrinsics of larger pictures": (K, "focal length and a centre", times(K, np.s_[:], 8)),
    "extrinsics in millimetres": (TOP, "within 10 m", times(TOP, np.s_[:, :3], 1000)),
    "extrinsics at the base": (TOP, "other than the base's own", times(TOP, np.s_[:, :3], 0)),
    "extrinsics swapped between cameras": (DEPTH, "gripper where", rows(swap_cameras)),
    "depth in centimetres": (DEPTH, "gripper where", _pictures(DEPTH, lambda depth: depth / 10)),
    "depth mirrored": (DEPTH, "gripper where", _pictures(DEPTH, lambda depth: depth[:, ::-1])),
    "depth in decimetres": (DEPTH, "depth in millimetres", _pictures(DEPTH, lambda depth: depth / 100)),
    "depth of one value": (DEPTH, "depths that show something", _pictures(DEPTH, lambda depth: depth * 0 + 700)),
    "depth that is not noted": (DEPTH, "noted as such", info(lambda f: f[DEPTH].update(info=None))),
    "black pictures": (RGB, "pictures that show something", _pictures(RGB, lambda rgb: rgb * 0)),
    "black pictures by their statistics": (RGB, "pictures that show something", stats_of_black),
    "names swapped": (A, "in this order", info(lambda told: told[A]["names"].reverse())),
    "names without a rotation": (S, "among the names", info(name_by_number)),
    "an instruction outside the grammar": (TEXT, "basic actions of", put(TEXT, 4, "do the dishes")),
    "an instruction that is empty": (TEXT, "basic actions of", put(TEXT, 4, "")),
    "an instruction with a stop token": (TEXT, "tokens of a language model", put(TEXT, 4, "grasp the cup <next goal>")),
    "no keyframe": (MARK, "a keyframe in every episode", put(MARK, np.s_[:], False)),
    "a next frame beyond the episode": (NEXT, "frames of the same episode", put(NEXT, np.s_[4:6], 9999)),
    "rows out of order": ("frame_index", "0, 1, 2", rows(turn_frames)),
    "times that stand still": ("timestamp", "times that increase", put("timestamp", np.s_[:], 0)),
    "a task that is none": ("task_index", "numbers of tasks", put("task_index", 2, -1)),
    "a bit that flipped": ("data/", "file that was written", flip_a_bit),
}  # fmt: skip
"""What is wrong: the column that is named, what the finding expects there, and what plants it in a dataset's folder."""


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two episodes of an arm of five joints with two cameras, annotated."""
    return fake_demonstrations(tmp_path_factory.mktemp("clean"), "five_joints", scale=0.1).root


def found_in(root: Path) -> list[Finding]:
    """As ``llakey check`` looks."""
    dataset = LeRobotDataset("me/arm", root=root)
    found = find(dataset.meta, needs_all(dataset.features, WORKSPACE))
    if not any(finding.certain for finding in found):
        found += check_pictures(draw(dataset, ("top", "side")), WORKSPACE)
    return found


def test_nothing_is_found_in_the_clean_one(clean: Path) -> None:
    assert [finding.sentence("it") for finding in found_in(clean)] == []


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_found(name: str, clean: Path, tmp_path: Path) -> None:
    column, expected, plant = FAULTS[name]
    root = tmp_path / "planted"
    shutil.copytree(clean, root)
    if name != "a bit that flipped":
        (root / CHECKSUMS).unlink()
    plant(root)
    found = [(finding.column, finding.expected) for finding in found_in(root)]
    assert any(where.startswith(column) and expected in what for where, what in found), found
