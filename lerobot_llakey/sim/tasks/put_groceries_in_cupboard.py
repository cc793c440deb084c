"""Put one of the groceries on the shelf of the cupboard (RLBench's ``put_groceries_in_cupboard``)."""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.arm.grasps import hand_yaw
from lerobot_llakey.sim.objects.groceries import GOODS, Good, add_good
from lerobot_llakey.sim.objects.meshes import add_mesh
from lerobot_llakey.sim.objects.placements import draw_until_it_fits
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

_WORDINGS = (
    "put the {} in the cupboard",
    "pick up the {} and place it in the cupboard",
    "move the {} to the bottom shelf",
    "put away the {} in the cupboard",
)
_SHOWN = 5
"""Goods on the table in one episode; the others stand under it, out of sight."""
_SHELF, _ROOF, _ROOF_EDGE, _DEPTH, _HALF_WIDTH = 0.02, 0.125, 0.108, 0.165, 0.14
"""Metres: height of the shelf and of the roof, where the roof begins behind the shelf's edge, how deep the shelf is and
half its width. A hand that points down stands in front of the roof."""
_WALL = 0.008
_WOOD, _PALE = (0.50, 0.32, 0.18, 1.0), (0.80, 0.66, 0.46, 1.0)
_INWARDS, _SPARE = 0.062, 0.006
"""Metres behind the shelf's edge where a good is put, and above the shelf where it is let go."""
_PLACES, _ROOM, _TALL = (0.0, 0.085, -0.085), 0.075, 0.032
"""Metres beside the shelf's middle where a good may go, the first choice first; how far others must be from it; half
the height from which the hand that holds a good stays above the cupboard's walls."""
_BEFORE, _OVER = 0.08, 0.105
"""Metres from the shelf's edge, and above the height of placing, of a good at the front of the cupboard."""
_ABOVE, _CARRY = 0.10, 0.20
"""Metres from a good to the hand before it grasps, and height of the hand that has raised one."""
_TOP_GRIP, _LOWEST_GRIP = 0.026, 0.018
"""Metres of a good's top that the fingers reach down over, and of their least height above what it stands on."""
_FINGERTIP = 0.011
"""Metres that the fingertips need below the tool's centre point."""
_FINGERS = np.array(((0.012, 0.05, 0.0), (-0.012, 0.05, 0.0), (0.012, -0.05, 0.0), (-0.012, -0.05, 0.0)))
"""Corners of the open fingers in the tool's frame, metres."""
_WIDEST = 0.067
"""Metres between the faces of a good that the hand can take."""
_ARRIVED, _TURNED = 0.045, 0.35
"""How far (metres, and radians) a hand may be off and still be at the front: the next waypoint corrects the rest."""
_X, _Y, _REACH = (0.31, 0.62), (-0.32, 0.32), (0.40, 0.66)
"""Metres: where goods stand, and how far from the base, so that a hand that points down reaches them."""
_GAP, _FRONT_GAP, _SIDE_GAP = 0.145, 0.10, 0.28
"""Metres between goods, before the shelf's edge, and beside the cupboard's middle: the hand is 20 cm wide."""


class PutGroceriesInCupboard(Task):
    """Nine variations, one for each good; four others stand around the one that is asked for."""

    name: ClassVar[str] = "put_groceries_in_cupboard"
    variations: ClassVar[int] = len(GOODS)

    def build(self, spec: mujoco.MjSpec) -> None:
        for good in GOODS:
            add_good(spec, good)
        _add_cupboard(spec)

    def reset(self, world: World, variation: int) -> None:
        rng = world.rng
        self.variation, self.good = variation, GOODS[variation]
        self.description = str(rng.choice(_WORDINGS)).format(self.good.name)
        heading = rng.uniform(-0.15, 0.15)
        cupboard = Pose(
            np.array((rng.uniform(0.57, 0.60), rng.uniform(-0.14, 0.14), 0.0)),
            Rotation.from_euler("z", heading).as_quat(),
        )
        world.place("cupboard", cupboard)
        others = rng.permutation([index for index in range(len(GOODS)) if index != variation])
        shown, hidden = (variation, *others[: _SHOWN - 1]), others[_SHOWN - 1 :]
        positions = draw_until_it_fits(lambda: _draw_positions(rng, cupboard), "a cupboard and its groceries")
        for index, position in zip(shown, positions, strict=True):
            yaw = rng.uniform(-0.6, 0.6)
            _stand(world, GOODS[index], (*position, 0.0), yaw)
        for place, index in enumerate(hidden):
            _stand(world, GOODS[index], (0.1 + 0.12 * place, 0.0, -0.75), 0.0)

    def success(self, world: World) -> bool:
        return self._inside(world) and self.good.body not in world.held_bodies()

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        held = world.held_bodies()
        if self.good.body in held:
            return self._carry(world)
        wrong = [good for good in GOODS if good.body in held]
        return [release(world.tool, f"the {good.name}") for good in wrong] + self._fetch(world)

    def _inside(self, world: World) -> bool:
        """Whether the middle of the good is in the cupboard, at the height of one that rests on the shelf."""
        x, y, z = world.pose("cupboard").inverse().apply(world.pose(self.good.body).position)
        return bool(0 < x < _DEPTH and abs(y) < _HALF_WIDTH and z < _SHELF + self._half_height(world) + 0.01)

    def _half_height(self, world: World) -> float:
        return self.good.half_extent(world.pose(self.good.body).rotation.as_matrix()[2])

    def _grasp(self, world: World) -> Pose:
        """The hand over the good as it stands or lies."""
        pose, half = world.pose(self.good.body), self._half_height(world)
        grasp = Pose(pose.position, top_down(self._yaw(pose)))
        # A finger between the good and the cupboard stays above the shelf.
        fingers = world.pose("cupboard").inverse().apply(grasp.apply(_FINGERS))
        over_shelf = (fingers[:, 0] > 0).any() and (np.abs(fingers[:, 1]) < _HALF_WIDTH).any()
        lowest = _SHELF + _FINGERTIP if over_shelf else _LOWEST_GRIP
        return grasp.shifted(z=max(lowest - half, half - _TOP_GRIP))

    def _yaw(self, pose: Pose) -> float:
        """The smallest turn of the hand with which its fingers lie flat on two faces."""
        axes = pose.rotation.as_matrix().T
        upright = int(np.abs(axes[:, 2]).argmax())
        if self.good.round and upright == 2:
            return 0.0
        yaws = []
        for axis in range(3):
            if axis == upright or (self.good.size[axis] > _WIDEST / 2):
                continue
            across = axes[axis]
            if self.good.round and axis != 2:
                across = np.cross(axes[2], (0, 0, 1))
            yaw = np.arctan2(-across[0], across[1])
            yaws.append(float(np.pi / 2 - (np.pi / 2 - yaw) % np.pi))
        return min(yaws, key=abs)

    def _fetch(self, world: World) -> list[Waypoint]:
        """All steps, or those from the grasp on where the hand waits above the good."""
        grasp = self._grasp(world)
        steps = grasping(world, grasp.shifted(z=_ABOVE), grasp, "top", f"the {self.good.name}")
        return steps + self._bring(world, grasp, world.pose(self.good.body))

    def _free_place(self, world: World, half_height: float) -> float:
        """Metres beside the shelf's middle: the first place that no other good has taken.

        A hand that holds something low would meet the walls: it pushes aside what stands in the middle.
        """
        if half_height < _TALL:
            return _PLACES[0]
        others = np.array([world.pose(good.body).position for good in GOODS if good is not self.good])
        offsets = world.pose("cupboard").inverse().apply(others)
        taken = offsets[(np.abs(offsets[:, 0] - _INWARDS) < _ROOM) & (offsets[:, 2] > 0), 1]
        return next((place for place in _PLACES if (np.abs(taken - place) > _ROOM).all()), _PLACES[0])

    def _bring(self, world: World, tool: Pose, good: Pose) -> list[Waypoint]:
        """The steps from the raise on, for a good held at ``good`` by a hand at ``tool``, upright or nearly so."""
        yaw = hand_yaw(tool)
        held = Pose(tool.position, top_down(yaw)).inverse() @ good
        cupboard = world.pose("cupboard")
        hand = Pose(np.zeros(3), top_down(float(cupboard.rotation.as_euler("zyx")[0])))
        half = self.good.half_extent((hand @ held).rotation.as_matrix()[2])
        position = np.array((_INWARDS, self._free_place(world, half), _SHELF + _SPARE + half))
        placed = Pose(cupboard.apply(position) - hand.apply(held.position), hand.quaternion)
        front = Pose(
            cupboard.apply(position + (-_INWARDS - _BEFORE, 0, _OVER)) - hand.apply(held.position), hand.quaternion
        )
        raised = Pose(np.array((*tool.position[:2], _CARRY)), top_down(yaw))
        return [
            Waypoint(raised, False, True, instruct("raise")),
            Waypoint(front, False, False, instruct("move", "front", "the cupboard")),
            Waypoint(placed, False, True, instruct("place", f"the {self.good.name}", "the shelf")),
            release(placed, f"the {self.good.name}"),
        ]

    def _carry(self, world: World) -> list[Waypoint]:
        """The steps that remain for the good in the hand."""
        tool = world.tool
        steps = self._bring(world, tool, world.pose(self.good.body))
        front, placed = steps[1].pose, steps[2].pose
        if self._inside(world) and tool.distance(placed)[1] < _TURNED:
            return steps[3:]
        turn = tool.distance(front)[1]
        if tool.distance(front)[0] < _ARRIVED and turn < _TURNED:
            return steps[2:]
        return steps[1:] if tool.position[2] > _CARRY - 0.04 else steps


def _stand(world: World, good: Good, position: tuple[float, float, float], yaw: float) -> None:
    centre = np.add(position, (0, 0, good.size[2]))
    world.place(good.body, Pose(centre, Rotation.from_euler("z", yaw).as_quat()))


def _draw_positions(rng: np.random.Generator, cupboard: Pose) -> np.ndarray | None:
    """(_SHOWN, 2) positions of the goods, added one by one; None where one finds no room."""
    positions: list[np.ndarray] = []
    for _ in range(200):
        position = np.array((rng.uniform(*_X), rng.uniform(*_Y)))
        x, y, _ = cupboard.inverse().apply(np.array((*position, 0.0)))
        clear = x < -_FRONT_GAP or abs(y) > _SIDE_GAP
        if (
            clear
            and _REACH[0] < np.hypot(*position) < _REACH[1]
            and all(np.hypot(*(position - s)) > _GAP for s in positions)
        ):
            positions.append(position)
        if len(positions) == _SHOWN:
            return rng.permutation(np.array(positions))
    return None


def _add_cupboard(spec: mujoco.MjSpec) -> None:
    """A shelf between two walls, with a roof over its rear part; it opens towards -x and has no back wall."""
    box = mujoco.mjtGeom.mjGEOM_BOX
    cupboard = spec.worldbody.add_body(name="cupboard", pos=(0.6, 0, 0))
    cupboard.add_geom(
        type=box,
        size=(_DEPTH / 2, _HALF_WIDTH, _SHELF / 2),
        pos=(_DEPTH / 2, 0, _SHELF / 2),
        rgba=_PALE,
        friction=(0.8, 0.01, 0.0001),
    )
    depth = (_DEPTH - _ROOF_EDGE) / 2
    cupboard.add_geom(
        type=box,
        size=(depth, _HALF_WIDTH + 2 * _WALL, _WALL / 2),
        pos=(_ROOF_EDGE + depth, 0, _ROOF + _WALL / 2),
        rgba=_WOOD,
    )
    # Strips along the back keep things from sliding out, yet let the front camera look in.
    for z in (_SHELF, _ROOF + _WALL):
        cupboard.add_geom(
            type=box, size=(_WALL / 2, _HALF_WIDTH, 0.012), pos=(_DEPTH - _WALL / 2, 0, z + 0.012), rgba=_WOOD
        )
    outline = np.array(((0, 0), (_DEPTH, 0), (_DEPTH, _ROOF), (_ROOF_EDGE, _ROOF), (0, _SHELF + 0.03)))
    for name, y in (("left", _HALF_WIDTH), ("right", -_HALF_WIDTH - 2 * _WALL)):
        sides = [np.column_stack((outline[:, 0], np.full(len(outline), y + d), outline[:, 1])) for d in (0, 2 * _WALL)]
        mesh = add_mesh(spec, f"cupboard_{name}", np.concatenate(sides))
        cupboard.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, rgba=_WOOD)
