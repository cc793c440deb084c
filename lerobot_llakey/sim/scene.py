"""What every task's scene has in common: table, light, robot and cameras."""

from __future__ import annotations

import mujoco
import numpy as np

from lerobot_llakey.sim.arm.panda import panda_spec
from lerobot_llakey.sim.cameras import add_cameras

TIMESTEP = 0.004
_TABLE_COLOURS = ((0.56, 0.45, 0.33), (0.62, 0.55, 0.45), (0.50, 0.43, 0.37), (0.66, 0.62, 0.55))


def base_spec(detailed: bool = False) -> mujoco.MjSpec:
    """The robot on a table whose top is at z = 0, lit from above, with all cameras.

    Args:
        detailed: see :func:`lerobot_llakey.sim.arm.panda.panda_spec`.
    """
    spec = panda_spec(detailed)
    spec.modelname = "llakey"
    option = spec.option
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.noslip_iterations = 3
    # Shadows are never drawn, and their map of 4096 x 4096 would take 64 MB a camera size.
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 0, 0
    spec.visual.map.znear, spec.visual.map.zfar = 0.02, 8.0
    spec.stat.extent = 1.0
    spec.stat.center = (0.4, 0.0, 0.2)
    spec.visual.headlight.ambient = (0.45, 0.45, 0.45)
    spec.visual.headlight.diffuse = (0.45, 0.45, 0.45)
    spec.visual.headlight.specular = (0.05, 0.05, 0.05)
    spec.worldbody.add_light(
        name="lamp", pos=(0.5, 0.3, 2.0), dir=(0.0, -0.1, -1.0), diffuse=(0.5, 0.5, 0.5), specular=(0.1, 0.1, 0.1)
    )
    box = mujoco.mjtGeom.mjGEOM_BOX
    table = spec.worldbody.add_body(name="table", pos=(0.35, 0.0, -0.02))
    table.add_geom(
        name="table", type=box, size=(0.65, 0.7, 0.02), rgba=(*_TABLE_COLOURS[0], 1.0), friction=(0.8, 0.005, 0.0001)
    )
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(3, 3, 0.1), pos=(0, 0, -0.75), rgba=(0.30, 0.32, 0.35, 1)
    )
    add_cameras(spec)
    return spec


def vary_look(model: mujoco.MjModel, rng: np.random.Generator) -> None:
    """Draw the table's colour and the lamp's place and strength of one episode."""
    model.geom("table").rgba[:3] = np.clip(_TABLE_COLOURS[rng.integers(4)] + rng.uniform(-0.04, 0.04, 3), 0, 1)
    light = model.light("lamp")
    light.pos[:] = (0.5 + rng.uniform(-0.4, 0.4), rng.uniform(-0.5, 0.5), 2.0)
    light.diffuse[:] = rng.uniform(0.3, 0.5)
