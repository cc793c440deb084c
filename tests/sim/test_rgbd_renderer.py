"""Colour and depth drawn at once are what MuJoCo draws one after the other."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.schema import CAMERAS
from lerobot_llakey.sim.rgbd_renderer import RGBDRenderer
from lerobot_llakey.sim.simulation import Simulation

SIZE = 48


def both(renderer: mujoco.Renderer) -> tuple[np.ndarray, np.ndarray]:
    """MuJoCo's own pictures."""
    rgb = renderer.render()
    renderer.enable_depth_rendering()
    depth = renderer.render()
    renderer.disable_depth_rendering()
    return rgb, depth


@pytest.mark.parametrize("opacity", [1.0, 0.4])
def test_pictures_are_mujocos_to_the_last_bit(simulation: Simulation, opacity: float) -> None:
    world = simulation.world
    simulation.reset(0)
    world.model.geom("table").rgba[3] = opacity
    world.model.vis.global_.offheight, world.model.vis.global_.offwidth = SIZE, SIZE
    renderer = RGBDRenderer(world.model, SIZE, SIZE)
    for camera in CAMERAS:
        renderer.update_scene(world.data, camera)
        rgb, depth = renderer.render_rgbd()
        expected_rgb, expected_depth = both(renderer)
        assert rgb.dtype == np.uint8 and depth.dtype == np.float32
        assert np.array_equal(rgb, expected_rgb) and np.array_equal(depth, expected_depth)
        assert len(np.unique(depth)) > SIZE
    renderer.close()
