"""Open the bottom, middle or top drawer of a cabinet (RLBench's ``open_drawer``)."""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping
from lerobot_llakey.sim.world import World

DRAWERS = ("bottom", "middle", "top")
_WORDINGS = (
    "open the {} drawer",
    "grip the {} handle and pull the {} drawer open",
    "slide the {} drawer open",
)
_HEIGHTS = (0.065, 0.16, 0.255)
_HALF_DEPTH, _HALF_WIDTH, _HALF_HEIGHT, _WALL = 0.12, 0.13, 0.043, 0.006
_HANDLE_REACH = 0.05
"""Metres from the drawer's front to the middle of its handle."""
_TRAVEL = 0.20
_OPEN = 0.15
"""Metres of opening that count as open, as in RLBench."""
_PULL = 0.175
_APPROACH = 0.09
_SPIN = 0.35
"""Radians by which the hand may be turned before its grasp: between handle and front there is no room to turn."""
_TILT = np.deg2rad(-24)
"""The hand comes from above at 66 degrees below the horizontal, within the arm's reach at every drawer."""
_WOOD = (0.72, 0.53, 0.34, 1.0)
_FRONT = (0.86, 0.70, 0.50, 1.0)
_METAL = (0.20, 0.20, 0.22, 1.0)


class OpenDrawer(Task):
    """Three variations, one for each drawer; the cabinet's place and heading vary."""

    name: ClassVar[str] = "open_drawer"
    variations: ClassVar[int] = 3

    def build(self, spec: mujoco.MjSpec) -> None:
        box = mujoco.mjtGeom.mjGEOM_BOX
        cabinet = spec.worldbody.add_body(name="cabinet", pos=(0.7, 0, 0))
        height = _HEIGHTS[-1] + _HALF_HEIGHT + 2 * _WALL
        for side in (-1, 1):
            size, y = (_HALF_DEPTH, _WALL, height / 2), side * (_HALF_WIDTH + 2 * _WALL)
            cabinet.add_geom(type=box, size=size, pos=(0, y, height / 2), rgba=_WOOD)
        cabinet.add_geom(
            type=box, size=(_WALL, _HALF_WIDTH + _WALL, height / 2), pos=(_HALF_DEPTH, 0, height / 2), rgba=_WOOD
        )
        for z in (0.01, height):
            cabinet.add_geom(
                type=box, size=(_HALF_DEPTH + _WALL, _HALF_WIDTH + 3 * _WALL, 0.01), pos=(0, 0, z), rgba=_WOOD
            )
        for name, z in zip(DRAWERS, _HEIGHTS, strict=True):
            _add_drawer(cabinet, name, z)
            # The slides guide the drawers; contact with their own cabinet would only make them jam.
            spec.add_exclude(bodyname1="cabinet", bodyname2=f"{name}_drawer")

    def reset(self, world: World, variation: int) -> None:
        rng = world.rng
        self.variation, self.drawer = variation, DRAWERS[variation]
        self.description = str(rng.choice(_WORDINGS)).format(self.drawer, self.drawer)
        heading = rng.uniform(-0.25, 0.25)
        place = (rng.uniform(0.72, 0.77), rng.uniform(-0.12, 0.12), 0.0)
        world.place("cabinet", Pose(np.array(place), Rotation.from_euler("z", heading).as_quat()))

    def success(self, world: World) -> bool:
        return world.joint(f"{self.drawer}_drawer") >= _OPEN

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        handle_name = f"the {self.drawer} handle"
        grasp = self._grasp(world)
        before = grasp.advanced(-_APPROACH)
        outwards = world.pose("cabinet").rotation.apply((-1.0, 0.0, 0.0))
        left = _PULL - world.joint(f"{self.drawer}_drawer")
        pulled = grasp @ Pose(grasp.rotation.inv().apply(outwards) * left)
        pull = Waypoint(pulled, False, True, instruct("pull_open", f"the {self.drawer} drawer"))
        if world.holds(f"{self.drawer}_drawer"):
            return [pull]
        return [*grasping(world, before, grasp, "front", handle_name, spin=_SPIN), pull]

    def _grasp(self, world: World) -> Pose:
        """The tool's pose around the handle, its fingers at both ends."""
        handle = world.site(f"{self.drawer}_handle")
        hand = Rotation.from_euler("y", _TILT) * Rotation.from_quat((1.0, 0.0, 0.0, 0.0))
        return Pose(handle.position, (world.pose("cabinet").rotation * hand).as_quat())


def _add_drawer(cabinet: mujoco.MjsBody, name: str, z: float) -> None:
    box = mujoco.mjtGeom.mjGEOM_BOX
    drawer = cabinet.add_body(name=f"{name}_drawer", pos=(0, 0, z))
    drawer.add_joint(
        name=f"{name}_drawer",
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=(-1, 0, 0),
        range=(0, _TRAVEL),
        limited=True,
        damping=8.0,
        frictionloss=1.0,
    )
    inside = {"type": box, "rgba": _FRONT, "mass": 0.1, "contype": 0, "conaffinity": 0}
    depth = _HALF_DEPTH - 2 * _WALL
    drawer.add_geom(size=(depth, _HALF_WIDTH - _WALL, _WALL), pos=(0, 0, -_HALF_HEIGHT + 2 * _WALL), **inside)
    for side in (-1, 1):
        drawer.add_geom(size=(depth, _WALL / 2, 0.03), pos=(0, side * (_HALF_WIDTH - _WALL), -0.012), **inside)
    front = -_HALF_DEPTH
    drawer.add_geom(
        type=box,
        size=(_WALL, _HALF_WIDTH + _WALL, _HALF_HEIGHT),
        pos=(front, 0, 0),
        rgba=_FRONT,
        mass=0.2,
    )
    drawer.add_geom(
        type=box, size=(_HANDLE_REACH / 2, 0.008, 0.008), pos=(front - _HANDLE_REACH / 2, 0, 0), rgba=_METAL, mass=0.02
    )
    drawer.add_geom(
        type=box,
        size=(0.013, 0.024, 0.013),
        pos=(front - _HANDLE_REACH, 0, 0),
        rgba=_METAL,
        mass=0.03,
        friction=(1.2, 0.01, 0.0001),
    )
    drawer.add_site(name=f"{name}_handle", pos=(front - _HANDLE_REACH, 0, 0), group=5)
