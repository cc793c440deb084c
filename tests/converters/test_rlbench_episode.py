"""Numbers of an episode in the contract's terms; the cameras' geometry holds when points are projected again."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from fakes_rlbench import FAR, NEAR, RecordedFrames, rlbench_camera, write_episode
from lerobot_llakey import geometry, schema
from lerobot_llakey.converters.rlbench_episode import opencv_camera, read_numbers
from lerobot_llakey.converters.rlbench_files import find_episodes
from lerobot_llakey.errors import LlakeyError


def test_states_are_those_that_were_recorded(episodes: Path, frames: RecordedFrames) -> None:
    (folder,) = find_episodes(episodes)
    numbers = read_numbers(folder, folder.observations())
    states = frames.episode.states[frames.steps]
    assert np.allclose(numbers.states, states, atol=1e-6)
    assert np.allclose(numbers.velocities[:, :7], frames.episode.velocities[frames.steps, :7], atol=1e-6)
    assert numbers.gripper_open.tolist() == (states[:, schema.GRIPPER] > 0.9).tolist()
    assert numbers.ignore_collision.all()


def test_a_point_in_the_world_lands_where_rlbenchs_own_matrices_put_it(frames: RecordedFrames) -> None:
    picture = frames.pictures[0]["front"]
    known = rlbench_camera("front", picture.intrinsics, picture.pose)
    theirs_inner, theirs_outer = known["front_camera_intrinsics"], known["front_camera_extrinsics"]
    inner, outer = opencv_camera(theirs_inner, theirs_outer)
    points = np.random.default_rng(0).uniform((0.2, -0.3, 0.0), (0.8, 0.3, 0.4), (50, 3))

    def projected(matrix: np.ndarray, camera_to_world: np.ndarray) -> np.ndarray:
        local = (points - camera_to_world[:3, 3]) @ camera_to_world[:3, :3]
        pixels = local @ matrix.T
        return pixels[:, :2] / pixels[:, 2:]

    ours = projected(
        geometry.intrinsics_to_matrix(torch.tensor(inner)).double().numpy(),
        geometry.pose_to_matrix(torch.tensor(outer)).double().numpy(),
    )
    assert np.abs(ours - projected(theirs_inner, theirs_outer)).max() < 1e-3, "pixels"
    assert (inner[:2] > 0).all() and np.allclose(inner, picture.intrinsics)
    assert np.allclose(
        geometry.pose_to_matrix(outer.astype(np.float64)), geometry.pose_to_matrix(picture.pose), atol=1e-5
    )


def test_depth_lifts_the_table_to_its_true_height(episodes: Path) -> None:
    (folder,) = find_episodes(episodes)
    track = read_numbers(folder, folder.observations()).cameras["front"]
    depth = torch.tensor(folder.depth("front", 0, NEAR, FAR))
    matrices = (
        geometry.intrinsics_to_matrix(torch.tensor(track.intrinsics[0])).double(),
        geometry.pose_to_matrix(torch.tensor(track.extrinsics[0])).double(),
    )
    points = geometry.unproject(depth, *matrices).reshape(-1, 3)
    near = points[(points[:, 0] > 0.2) & (points[:, 0] < 0.7) & (points[:, 1].abs() < 0.4)]
    assert (near[:, 2].abs() < 0.005).double().mean() > 0.3, "much of what is seen is the table at height 0"
    assert near[:, 2].min() > -0.02


def _of(name: str, value: Any) -> Callable[[list[Any]], None]:
    return lambda observations: setattr(observations[3], name, value)


def _misc(name: str, value: Any) -> Callable[[list[Any]], None]:
    return lambda observations: observations[3].misc.update({name: value})


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (_of("gripper_pose", None), "7 finite numbers as gripper_pose at time step 3"),
        (_of("joint_positions", np.zeros(6)), "7 finite numbers as joint_positions at time step 3"),
        (_of("joint_velocities", np.full(7, np.nan)), "joint_velocities at time step 3"),
        (_of("gripper_open", "wide"), "one finite numbers as gripper_open"),
        (_of("misc", None), "front_camera_intrinsics"),
        (_misc("wrist_camera_far", 0.001), "near < far for wrist at time step 3"),
        (_misc("front_camera_extrinsics", np.diag([2.0, 1, 1, 1])), "rigid pose"),
        (_misc("front_camera_intrinsics", np.diag([-50.0, 50, 1])), "focal lengths of one sign"),
    ],
)
def test_a_wrong_number_is_named(
    tmp_path: Path, frames: RecordedFrames, change: Callable[[list[Any]], None], match: str
) -> None:
    write_episode(tmp_path / "t" / "all_variations" / "episodes" / "episode0", frames, change=change)
    (folder,) = find_episodes(tmp_path)
    with pytest.raises(LlakeyError, match=match):
        read_numbers(folder, folder.observations())


def test_versions_that_record_less_are_read(tmp_path: Path, frames: RecordedFrames) -> None:
    def strip(observations: list[Any]) -> None:
        for one in observations:
            del one.ignore_collisions, one.gripper_joint_positions

    write_episode(tmp_path / "t" / "all_variations" / "episodes" / "episode0", frames, change=strip)
    (folder,) = find_episodes(tmp_path)
    numbers = read_numbers(folder, folder.observations())
    assert set(numbers.states[:, schema.GRIPPER]) == {0.0, 1.0} and numbers.ignore_collision.all()
