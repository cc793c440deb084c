"""Depth from files beside a recording: exact in the copy, and whatever is missing is said before work."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from PIL import Image

from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import find, needs_all
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.camera_calibration import CameraCalibration
from lerobot_llakey.datasets.depth_files import find_depth
from lerobot_llakey.errors import LlakeyError

SIZE, LENGTHS = (32, 48), (8, 6)
TEXTS = ["grasp the cup"]
CALIBRATION = CameraCalibration(np.array([50, 50, 24, 16], np.float32), np.array([0.5, 0, 0.6, 1, 0, 0, 0], np.float32))


def depth_of(episode: int, frame: int) -> np.ndarray:
    """Millimetres (H, W), with a hole and a far end."""
    picture = 500 + 100 * episode + 3 * frame + np.arange(SIZE[0] * SIZE[1]).reshape(SIZE) % 300
    picture[0, 0], picture[1, 1] = 0, 60000
    return picture.astype(np.uint16)


def write_depth(folder: Path) -> Path:
    for episode, length in enumerate(LENGTHS):
        place = folder / "front" / f"episode_{episode:03d}"
        place.mkdir(parents=True)
        for frame in range(length):
            Image.fromarray(depth_of(episode, frame)).save(place / f"frame_{frame:06d}.png")
    return folder


@pytest.fixture(scope="module", params=["image", "video"])
def source(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    """Two episodes of colours and the hand's pose."""
    root, dtype = tmp_path_factory.mktemp("depth") / "source", request.param
    axes = ["height", "width", "channels"]
    features = {
        schema.STATE: schema.vector(schema.POSE_NAMES),
        schema.ACTION: schema.vector(schema.POSE_NAMES),
        schema.image_key("front"): {"dtype": dtype, "shape": (*SIZE, 3), "names": axes},
    }
    dataset = LeRobotDataset.create("me/source", 10, features, root=root, use_videos=dtype == "video")
    for length in LENGTHS:
        for frame in range(length):
            pose = np.array([0.3 + 0.02 * frame, 0, 0.3, 1, 0, 0, 0], dtype=np.float32)
            picture = np.full((*SIZE, 3), 10 * frame, dtype=np.uint8)
            dataset.add_frame(
                {schema.STATE: pose, schema.ACTION: pose, schema.image_key("front"): picture, schema.TASK: "take it"}
            )
        dataset.save_episode(parallel_encoding=False)
    dataset.finalize()
    return LeRobotDataset("me/source", root=root)


def test_depth_is_exact_in_the_copy(source: LeRobotDataset, tmp_path: Path) -> None:
    depth = find_depth(write_depth(tmp_path / "depth"), source.meta)
    found = find_keyframes(source)
    calibration = {"front": CALIBRATION}
    texts = {0: TEXTS, 1: TEXTS}
    copy = annotate(source, found, texts, tmp_path / "copy", "me/copy", calibration=calibration, depth=depth)
    key = schema.depth_key("front")
    farthest = round(1000 * schema.DEPTH_RANGE_METRES[1])
    for index, (episode, frame) in enumerate((e, f) for e, length in enumerate(LENGTHS) for f in range(length)):
        item = copy[index]
        wanted = np.minimum(depth_of(episode, frame), farthest)
        np.testing.assert_array_equal(np.squeeze(np.asarray(item[key])), wanted)
        np.testing.assert_array_equal(item[schema.image_key("front")], source[index][schema.image_key("front")])
    assert schema.cameras_of(copy.features, depth=True) == ("front",)
    assert copy.meta.stats is not None and copy.meta.stats[key]["mean"].shape == (1, 1, 1)
    assert 500 < float(copy.meta.stats[key]["mean"].item()) < 1000
    assert copy.features[key]["info"]["depth_unit"] == "mm"
    assert not [finding for finding in find(copy.meta, needs_all(copy.features)) if finding.column == key]


def _without_a_frame(folder: Path) -> None:
    (folder / "front" / "episode_001" / "frame_000003.png").unlink()


def _with_one_more(folder: Path) -> None:
    Image.fromarray(depth_of(0, 0)).save(folder / "front" / "episode_000" / "frame_000008.png")


def _of_eight_bits(folder: Path) -> None:
    path = folder / "front" / "episode_000" / "frame_000002.png"
    Image.fromarray(np.zeros(SIZE, np.uint8)).save(path)


def _of_another_size(folder: Path) -> None:
    Image.fromarray(np.zeros((16, 24), np.uint16)).save(folder / "front" / "episode_000" / "frame_000000.png")


def _of_another_camera(folder: Path) -> None:
    (folder / "front").rename(folder / "side")


def _cut_off(folder: Path) -> None:
    path = folder / "front" / "episode_000" / "frame_000001.png"
    path.write_bytes(path.read_bytes()[:12])


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (
            _without_a_frame,
            r"6 depth pictures, frame_000000.png to frame_000005.png, in .*episode_001, got 5 .*003.png is m",
        ),
        (_with_one_more, r"8 depth pictures.*got 9 files \(frame_000008.png is not one of them\)"),
        (_of_eight_bits, r"grey of 16 bits and 48x32 pixels.*got 48x32 pixels of L"),
        (_of_another_size, r"48x32 pixels.* got 24x16 pixels of I;16"),
        (_of_another_camera, r"recording's cameras \(front\) in .*got side; rename them"),
        (_cut_off, r"Expected a readable PNG of depth at .*frame_000001.png"),
    ],
)
def test_what_does_not_fit_is_said_before_work(
    spoil: Callable[[Path], None], said: str, source: LeRobotDataset, tmp_path: Path
) -> None:
    spoil(write_depth(tmp_path / "depth"))
    with pytest.raises(LlakeyError, match=said) as raised:
        find_depth(tmp_path / "depth", source.meta)
    assert "\n" not in str(raised.value)


def test_no_folder_and_an_empty_one_are_said(source: LeRobotDataset, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="check --depth"):
        find_depth(tmp_path / "none", source.meta)
    with pytest.raises(LlakeyError, match=r"one folder a camera \(front\)"):
        find_depth(tmp_path, source.meta)
