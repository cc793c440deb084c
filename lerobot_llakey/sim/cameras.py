"""The policy's four RGB-D cameras and the human's camera."""

from __future__ import annotations

import atexit
import functools
import weakref
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import DOWN, nearest_sign, pinhole_intrinsics
from lerobot_llakey.schema import CAMERAS
from lerobot_llakey.sim.arm.panda import HULL_GROUP, VISUAL_GROUP
from lerobot_llakey.sim.mujoco_poses import wxyz
from lerobot_llakey.sim.rgbd_renderer import RGBDRenderer

VIEWER = "viewer"
"""The camera of videos made for people."""
_FLIP = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up, OpenCV's along z with y down."""


@dataclass(frozen=True)
class _FixedCamera:
    position: tuple[float, float, float]
    target: tuple[float, float, float]
    fovy: float


_FIXED = {
    "front": _FixedCamera((1.45, 0.0, 0.75), (0.47, 0.0, 0.13), 37.0),
    "left_shoulder": _FixedCamera((0.05, 0.75, 0.85), (0.50, 0.0, 0.10), 41.0),
    "right_shoulder": _FixedCamera((0.05, -0.75, 0.85), (0.50, 0.0, 0.10), 41.0),
    VIEWER: _FixedCamera((0.12, 1.15, 0.72), (0.48, 0.0, 0.18), 45.0),
}
_WRIST_FOVY = 70.0
_SPARE_GEOMS = 100
"""Room in a drawing for what MuJoCo adds to the model's geoms."""


@dataclass(frozen=True)
class RGBD:
    """One camera's picture.

    Attributes:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 z-depth in millimetres.
        intrinsics: (4,) float32 fx, fy, cx, cy in pixels.
        pose: (7,) float32 camera-to-base, OpenCV axes: position in metres, quaternion xyzw.
    """

    rgb: np.ndarray
    depth: np.ndarray
    intrinsics: np.ndarray
    pose: np.ndarray


def add_cameras(spec: mujoco.MjSpec) -> None:
    """Add the fixed cameras to the world and the wrist camera to the hand."""
    for name, camera in _FIXED.items():
        forward = np.subtract(camera.target, camera.position)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        up = np.cross(right, forward)
        axes = np.stack((right / np.linalg.norm(right), up / np.linalg.norm(up)))
        spec.worldbody.add_camera(name=name, pos=camera.position, quat=_orientation(axes), fovy=camera.fovy)
    # Behind the hand and looking along its z axis, tilted towards the fingertips.
    tilt = np.deg2rad(12)
    axes = np.array(((0.0, 1.0, 0.0), (np.cos(tilt), 0.0, np.sin(tilt))))
    spec.body("hand").add_camera(name="wrist", pos=(0.075, 0.0, 0.02), quat=_orientation(axes), fovy=_WRIST_FOVY)


class CameraRig:
    """Renders the cameras of one model; its OpenGL context lives in the process and thread that first renders."""

    def __init__(self, model: mujoco.MjModel, size: int) -> None:
        self.model, self.size = model, size
        self._renderers: dict[tuple[int, int], RGBDRenderer] = {}
        self._policy_view = _view_option(HULL_GROUP, VISUAL_GROUP)
        detailed = bool((model.geom_group == VISUAL_GROUP).any())
        self._human_view = _view_option(VISUAL_GROUP, HULL_GROUP) if detailed else self._policy_view

    def _renderer(self, height: int, width: int) -> RGBDRenderer:
        if (height, width) not in self._renderers:
            renderer = _make_renderer(self.model, height, width)
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
            self._renderers[height, width] = renderer
            _LIVE.add(self)
            _close_at_exit()
        return self._renderers[height, width]

    def render(self, data: mujoco.MjData, camera: str, before: RGBD | None = None) -> RGBD:
        """The camera's RGB-D picture of the present state; its quaternion's sign is nearest to the picture before."""
        renderer = self._renderer(self.size, self.size)
        renderer.update_scene(data, camera, self._policy_view)
        rgb, depth = renderer.render_rgbd()
        index = self.model.camera(camera).id
        intrinsics = pinhole_intrinsics(float(self.model.cam_fovy[index]), self.size, self.size)
        pose = camera_to_base(data, index, DOWN if before is None else before.pose[3:])
        return RGBD(rgb, depth * np.float32(1000), intrinsics.astype(np.float32), pose.astype(np.float32))

    def render_all(self, data: mujoco.MjData, before: Mapping[str, RGBD] | None = None) -> dict[str, RGBD]:
        """Pictures of all the policy's cameras, given those before within the episode, if any."""
        return {camera: self.render(data, camera, (before or {}).get(camera)) for camera in CAMERAS}

    def render_for_people(self, data: mujoco.MjData, height: int = 480, width: int = 640) -> np.ndarray:
        """(height, width, 3) uint8 picture of the detailed meshes from the viewer camera."""
        renderer = self._renderer(height, width)
        renderer.update_scene(data, VIEWER, self._human_view)
        return renderer.render().copy()

    def close(self) -> None:
        """Free the OpenGL contexts; the rig can render again afterwards."""
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()


_LIVE: weakref.WeakSet[CameraRig] = weakref.WeakSet()


@functools.cache
def _close_at_exit() -> None:
    """Free contexts before MuJoCo shuts EGL down: exit handlers run in reverse, so this is called after its own."""
    atexit.register(_close_live)


def _close_live() -> None:
    for rig in list(_LIVE):
        rig.close()


def _make_renderer(model: mujoco.MjModel, height: int, width: int) -> RGBDRenderer:
    """A renderer that takes 3 MB in place of 94: no buffers larger than its picture, no room for 10,000 geoms."""
    visual = model.vis.global_
    visual.offheight, visual.offwidth = height, width
    return RGBDRenderer(model, height, width, max_geom=model.ngeom + _SPARE_GEOMS)


def camera_to_base(data: mujoco.MjData, camera: int, reference: np.ndarray = DOWN) -> np.ndarray:
    """(7,) pose of a camera with OpenCV axes in the base frame, its quaternion of the sign nearer to a reference."""
    rotation = Rotation.from_matrix(data.cam_xmat[camera].reshape(3, 3) @ _FLIP)
    return np.concatenate((data.cam_xpos[camera], nearest_sign(rotation.as_quat(), reference)))


def _orientation(axes: np.ndarray) -> np.ndarray:
    """MuJoCo's quaternion of a camera frame given its x and y axes as rows (2, 3)."""
    rotation = np.stack((axes[0], axes[1], np.cross(axes[0], axes[1])), axis=1)
    return wxyz(Rotation.from_matrix(rotation).as_quat())


def _view_option(shown: int, hidden: int) -> mujoco.MjvOption:
    option = mujoco.MjvOption()
    option.geomgroup[:] = (1, 1, 1, 1, 0, 0)
    option.geomgroup[shown], option.geomgroup[hidden] = 1, 0
    option.sitegroup[:] = 0
    return option
