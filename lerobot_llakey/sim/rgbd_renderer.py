"""Colour and depth of a scene in one drawing: MuJoCo's own renderer draws the scene once for each."""

from __future__ import annotations

import mujoco
import numpy as np


class RGBDRenderer(mujoco.Renderer):
    """MuJoCo's renderer, which also gives both kinds of picture at once, the same to the last bit.

    See :class:`mujoco.Renderer` for the arguments.
    """

    def render_rgbd(self) -> tuple[np.ndarray, np.ndarray]:
        """Draw the scene as it was last updated.

        Drawing writes a depth for each pixel anyway. MuJoCo's depth differs from it only where a thing lets light
        through: there the drawing for depth takes all things as solid, so then it is made.

        Returns:
            Colours (H, W, 3) uint8, and z-depth (H, W) float32 in metres.
        """
        if self._translucent():
            rgb = self.render()
            self.enable_depth_rendering()
            depth = self.render()
            self.disable_depth_rendering()
            return rgb, depth
        if self._gl_context:
            self._gl_context.make_current()
        rgb = np.empty((self.height, self.width, 3), dtype=np.uint8)
        raw = np.empty((self.height, self.width), dtype=np.float32)
        mujoco.mjr_render(self._rect, self.scene, self._mjr_context)
        mujoco.mjr_readPixels(rgb, raw, self._rect, self._mjr_context)
        depth = self._metres(raw)
        return (rgb[::-1].copy(), depth[::-1].copy()) if self._gl_context else (rgb, depth)

    def _translucent(self) -> bool:
        """Whether a geom of the model is drawn but not solid."""
        model = self.model
        alphas = np.concatenate((model.geom_rgba[:, 3], model.mat_rgba[:, 3]))
        return bool(((alphas > 0) & (alphas < 1)).any())

    def _metres(self, raw: np.ndarray) -> np.ndarray:
        """Z-depth of OpenGL's reversed depth, by the planes of glFrustum in single precision, as MuJoCo takes them."""
        clip, extent = self.model.vis.map, self.model.stat.extent
        near, far = np.float32(clip.znear * extent), np.float32(clip.zfar * extent)
        scale = np.float32(-0.5) * (-(far + near) / (far - near)) - np.float32(0.5)
        offset = np.float32(-0.5) * (-(np.float32(2) * far * near) / (far - near))
        metres: np.ndarray = (offset / (raw.astype(np.float64) + scale)).astype(np.float32)
        return metres
