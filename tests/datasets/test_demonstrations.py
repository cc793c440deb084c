"""Recorded episodes become frames of the data contract, and dense datasets that keep them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lerobot.configs.video import DEPTH_QMAX
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.demonstrations import (
    ROBOT_TYPE,
    DemonstrationWriter,
    check_depth,
    depth_encoder,
    frames_of,
    keystep_rng,
    rgb_encoder,
    sim_features,
)
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.recorder import Episode, record
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task

SIZE, FPS = 32, 10
Recorded = tuple[Simulation, CameraRig, Episode]


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    """An episode of the drawer, and the simulation as the recorder left it."""
    simulation = Simulation(make_task("open_drawer"))
    episode = record(simulation, seed=3)
    assert episode.usable
    return simulation, CameraRig(simulation.world.model, SIZE), episode


def test_frames_fill_the_contract(recorded: Recorded) -> None:
    frames = frames_of(*recorded, [0])
    features = sim_features(SIZE, "video")
    assert set(frames[0]) == set(features) | {schema.TASK}
    for camera in schema.CAMERAS:
        assert frames[0][schema.image_key(camera)].shape == (SIZE, SIZE, 3)
        assert frames[0][schema.depth_key(camera)].shape == (SIZE, SIZE, 1)


def test_frames_come_in_the_order_asked_for_and_repeat(recorded: Recorded) -> None:
    episode = recorded[2]
    last = len(episode) - 1
    frames = frames_of(*recorded, [last, 0, last])
    for frame, index in zip(frames, (last, 0, last), strict=True):
        assert np.array_equal(frame[schema.STATE], episode.states[index])
        assert np.array_equal(frame[schema.VELOCITY], episode.velocities[index])
    front = schema.image_key("front")
    assert np.array_equal(frames[0][front], frames[2][front])
    assert not np.array_equal(frames[0][front], frames[1][front])
    frames[0][schema.TASK] = "changed"
    assert frames[2][schema.TASK] == episode.description, "each is a frame of its own"


def test_frames_carry_the_label_of_their_own_time(recorded: Recorded) -> None:
    episode = recorded[2]
    first = episode.keyframes[0]
    frames = frames_of(*recorded, [first - 1, first])
    # At a keyframe the next one is already asked for.
    assert [int(frame[schema.KEYFRAME_INDEX][0]) for frame in frames] == [0, 1]
    assert [bool(frame[schema.IS_KEYFRAME][0]) for frame in frames] == [False, True]
    for frame, reached in zip(frames, episode.keyframes[:2], strict=True):
        assert np.array_equal(frame[schema.ACTION][schema.POSITION], episode.states[reached][schema.POSITION])


def test_a_written_episode_is_read_back(recorded: Recorded, tmp_path: Path) -> None:
    frames = frames_of(*recorded, range(12))
    frames[7][schema.depth_key("wrist")][:4, :4, 0] = [
        [0, 20, 21, 30],
        [35, 40, 45, 49],
        [50, 51, 64, 99],
        [1, 2, 3, 4],
    ]
    with DemonstrationWriter("local/any", tmp_path / "dense", FPS, sim_features(SIZE, "video")) as writer:
        writer.add_episode(frames)
        writer.add_episode(frames[:6])
    dataset = LeRobotDataset("local/any", root=tmp_path / "dense")
    assert (dataset.num_episodes, len(dataset), dataset.fps) == (2, 18, FPS)
    assert dataset.meta.robot_type == ROBOT_TYPE
    for index, frame in ((7, frames[7]), (14, frames[2])):
        sample = dataset[index]
        assert np.allclose(sample[schema.STATE], frame[schema.STATE])
        farthest = schema.DEPTH_RANGE_METRES[1] * 1000
        for key in map(schema.depth_key, schema.CAMERAS):
            kept = frame[key][..., 0].clip(max=farthest)
            assert np.abs(sample[key].numpy()[0] - kept).max() < 1e-2, "millimetres"
        picture = sample[schema.image_key("front")].numpy().transpose(1, 2, 0) * 255
        assert np.abs(picture - frame[schema.image_key("front")]).mean() < 12, "lossy, yet the same picture"


def test_a_failure_while_writing_is_not_hidden(recorded: Recorded, tmp_path: Path) -> None:
    frame = frames_of(*recorded, [0])[0]
    del frame[schema.STATE]
    with (
        pytest.raises(ValueError, match=schema.STATE),
        DemonstrationWriter("local/any", tmp_path / "dense", FPS, sim_features(SIZE, "video")) as writer,
    ):
        writer.add_episode([frame])


def test_keysteps_are_drawn_anew_for_each_scene_and_alike_for_the_same(recorded: Recorded) -> None:
    episode = recorded[2]
    draws = [
        tuple(keystep_rng(one).integers(1000, size=8))
        for one in (episode, episode, replace(episode, seed=4), replace(episode, variation=episode.variation + 1))
    ]
    assert draws[0] == draws[1]
    assert len(set(draws)) == 3


def test_depth_is_kept_without_loss_and_pictures_play_in_browsers() -> None:
    depth = depth_encoder()
    assert (depth.depth_min, depth.depth_max) == schema.DEPTH_RANGE_METRES
    assert round(depth.depth_max * 1000, 6) == DEPTH_QMAX and not depth.use_log, "one code for each millimetre"
    assert "lossless=1" in str(depth.extra_options)
    assert rgb_encoder().vcodec == "h264"


def test_depth_kept_over_another_range_is_not_added_to(recorded: Recorded, tmp_path: Path) -> None:
    with DemonstrationWriter("local/any", tmp_path / "dense", FPS, sim_features(SIZE, "video")) as writer:
        writer.add_episode(frames_of(*recorded, range(4)))
    check_depth([tmp_path / "dense"])
    path = tmp_path / "dense" / "meta" / "info.json"
    path.write_text(path.read_text().replace('"video.depth_min": 0.0', '"video.depth_min": 0.05'))
    with pytest.raises(LlakeyError, match=r"'depth_min': 0.05.* into a new folder"):
        check_depth([tmp_path / "dense"])
