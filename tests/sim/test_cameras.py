"""Pictures, depth and calibration belong together."""

from dataclasses import replace
from typing import Any

import cv2
import mujoco
import numpy as np
import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.geometry import intrinsics_to_matrix, pose_to_matrix, unproject
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.simulation import Simulation


def test_depth_lifts_to_the_table_top(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    pictures = CameraRig(world.model, 64).render_all(world.data)
    assert tuple(pictures) == schema.CAMERAS
    for camera, picture in pictures.items():
        assert picture.rgb.shape == (64, 64, 3) and picture.rgb.dtype == np.uint8
        depth = torch.from_numpy(picture.depth / 1000)
        intrinsics = intrinsics_to_matrix(torch.from_numpy(picture.intrinsics))
        points = unproject(depth, intrinsics, torch.from_numpy(pose_to_matrix(picture.pose)))
        heights = points.reshape(-1, 3)[:, 2].numpy()
        share = np.mean(np.abs(heights) < 4e-3)
        assert share > 0.15, f"{camera} sees the table top at z = 0 in {share:.0%} of its pixels"


def test_front_camera_sees_the_hand_where_it_is(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    picture = CameraRig(world.model, 64).render(world.data, "left_shoulder")
    local = np.linalg.inv(pose_to_matrix(picture.pose)) @ np.append(world.site("top_handle").position, 1)
    u, v = (picture.intrinsics[:2] * local[:2] / local[2] + picture.intrinsics[2:]).astype(int)
    assert abs(picture.depth[v, u] / 1000 - local[2]) < 0.05


def test_the_sign_of_a_pose_is_nearest_to_the_picture_before(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    rig = CameraRig(world.model, 16)
    first = rig.render_all(world.data)
    flipped = {camera: replace(picture, pose=-picture.pose) for camera, picture in first.items()}
    for camera, picture in rig.render_all(world.data, flipped).items():
        np.testing.assert_array_equal(picture.pose[3:], -first[camera].pose[3:])
        np.testing.assert_array_equal(picture.pose[:3], first[camera].pose[:3])
    rig.close()


def test_people_see_a_larger_picture(simulation: Simulation) -> None:
    world = simulation.world
    simulation.reset(0)
    rig = CameraRig(world.model, 64)
    picture = rig.render_for_people(world.data, 120, 160)
    assert picture.shape == (120, 160, 3)
    assert cv2.Laplacian(picture, cv2.CV_64F).std() > 1
    rig.close()
    assert np.array_equal(rig.render_for_people(world.data, 120, 160), picture)


def test_a_rig_keeps_no_buffers_that_it_does_not_draw_in(
    simulation: Simulation, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = simulation.world
    made: list[tuple[int, int, int, int]] = []

    class Contexts(mujoco.MjrContext):
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            made.append((self.offHeight, self.offWidth, self.shadowSize, self.offSamples))

    monkeypatch.setattr(mujoco, "MjrContext", Contexts)
    simulation.reset(0)
    rig = CameraRig(world.model, 64)
    rig.render_all(world.data)
    rig.render_for_people(world.data, 120, 160)
    assert made == [(64, 64, 0, 0), (120, 160, 0, 0)]
    assert not simulation.clock.warnings(), "all geoms have room in the drawing"
    rig.close()
