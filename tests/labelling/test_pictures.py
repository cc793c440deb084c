"""Pictures come out as they were recorded, from images and from videos, and only so many are kept."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_recordings import fake_recording
from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.labelling.pictures import Pictures


@pytest.fixture(scope="module", params=[False, True], ids=["image", "video"])
def source(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return fake_recording(tmp_path_factory.mktemp("r") / "r", episodes=2, scale=0.25, video=request.param)


def _decoded(data: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(float)


def test_a_frame_is_the_recordings_own(source: LeRobotDataset) -> None:
    pictures = Pictures(source)
    (camera,) = pictures.cameras
    second = int(source.meta.episodes[1]["dataset_from_index"])
    last = int(source.meta.episodes[1]["length"]) - 1
    for frame in (0, 31, 32, last):
        item = source[second + frame][schema.image_key(camera)].numpy().transpose(1, 2, 0)
        recorded = item * (255 if item.max() <= 1 else 1)
        # JPEG alone is within a few levels; the scenes of two episodes, or of frames a second apart, are not.
        assert np.abs(_decoded(pictures.jpeg(1, camera, frame)) - recorded).mean() < 4
    other = _decoded(pictures.jpeg(0, camera, 0))
    assert np.abs(other - _decoded(pictures.jpeg(1, camera, 0))).max() > 60


def test_what_is_not_there_is_refused(source: LeRobotDataset) -> None:
    pictures = Pictures(source)
    (camera,) = pictures.cameras
    length = int(source.meta.episodes[0]["length"])
    for name, frame in ((camera, length), (camera, -1), ("none", 0)):
        with pytest.raises(LlakeyError, match=f"Expected a camera out of {camera} and a frame below {length}"):
            pictures.jpeg(0, name, frame)


def test_as_many_are_kept_as_fit(source: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[tuple[int, int]] = []
    real = Pictures._read
    monkeypatch.setattr(Pictures, "_read", lambda self, *place: read.append((place[0], place[2])) or real(self, *place))
    pictures = Pictures(source)
    (camera,) = pictures.cameras
    for frame in (0, 5, 31, 33, 2):
        pictures.jpeg(0, camera, frame)
    assert read == [(0, 0), (0, 32)]
    few = Pictures(source, most_bytes=1)
    for frame in (0, 33, 1):
        few.jpeg(0, camera, frame)
    assert read[2:] == [(0, 0), (0, 32), (0, 0)]


def test_large_pictures_are_made_smaller(source: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    pictures = Pictures(source)
    tall = np.zeros((1440, 720, 3), np.uint8)
    monkeypatch.setattr(pictures, "_read", lambda episode, camera, begin, end: [tall] * (end - begin))
    assert _decoded(pictures.jpeg(0, pictures.cameras[0], 0)).shape == (720, 360, 3)


def test_a_video_that_is_gone_is_said_in_a_sentence(tmp_path: Path) -> None:
    source = fake_recording(tmp_path / "r", episodes=1, scale=0.05, video=True)
    pictures = Pictures(source)
    path = source.root / source.meta.get_video_file_path(0, schema.image_key(pictures.cameras[0]))
    path.write_bytes(b"no video")
    with pytest.raises(LlakeyError, match="Expected a readable video at"):
        pictures.jpeg(0, pictures.cameras[0], 0)
    path.unlink()
    with pytest.raises(LlakeyError, match=r"Expected a video at .* found none"):
        pictures.jpeg(0, pictures.cameras[0], 0)
