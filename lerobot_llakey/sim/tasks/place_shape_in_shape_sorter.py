"""Put a shape through its own hole into the shape sorter (RLBench's ``place_shape_in_shape_sorter``)."""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import DOWN, Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.arm.planning import PlanningError
from lerobot_llakey.sim.objects import shape_sorter
from lerobot_llakey.sim.objects.shape_placements import free_positions, has_room, layout, over_sorter
from lerobot_llakey.sim.objects.shape_sorter import PLATE_BOTTOM, PLATE_TOP
from lerobot_llakey.sim.objects.shapes import BODY_HEIGHT, GRIP, SHAPES, Shape, add_shape, extent
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, points_alike, release
from lerobot_llakey.sim.world import World

_WORDINGS = (
    "put the {} in the shape sorter",
    "pick up the {} and put it in the sorter",
    "place the {} into its slot in the shape sorter",
    "slot the {} into the shape sorter",
)
_YAW = np.deg2rad(40)
_APPROACH, _CARRY = 0.10, 0.175
"""Metres from a grasp to the hand before it, and height of the hand above the table while it carries a shape."""
_OVER, _INTO = 0.025, 0.015
"""Metres from the sorter's top up to the shape's base when aligned, and down to it when let go."""
_ARRIVED, _IN, _PUT, _TURNED = 0.015, 0.009, 0.02, 0.35
"""Metres sideways from the hole at which a shape can be lowered, at which one lowered can be let go, metres by which
the hand may be off where it puts a shape back on the table, and radians by which it may be off in all three."""
_FINGERTIP = 0.011
"""Metres that the fingers need below the tool's centre point."""
_TURNS, _SIDESTEPS = np.deg2rad((0, 90, 22, -22, 45, -45, 68, -68)), (0.0, 0.012, -0.012, 0.025, -0.025)
"""Radians by which the hand may be turned from the bar, which turns as the fingers close on it, and metres by which it
may stand to one side: for shapes that something stands too close to."""
_SPIN, _FITTING = np.deg2rad((90, 60))
"""Radians by which the hand may be turned before its grasp, and above the hole: there is room to turn on the way."""
_UPRIGHT, _LYING = np.deg2rad((10, 35))
"""Radians of tilt in the hand that need no correction, and that are too many to correct over the hole (the shape is put
back on the table, where it rights itself)."""
_LEANS, _NEAREST = np.deg2rad((50, 30, 0)), 5
"""Radians by which the hand leans to put back a lying shape, and how many places are tried: the first that the arm
reaches."""


class PlaceShapeInShapeSorter(Task):
    """Five variations, one for each shape; all five stand around the sorter in every scene."""

    name: ClassVar[str] = "place_shape_in_shape_sorter"
    variations: ClassVar[int] = len(SHAPES)
    shape: Shape = SHAPES[0]

    def build(self, spec: mujoco.MjSpec) -> None:
        shape_sorter.add_shape_sorter(spec)
        for shape in SHAPES:
            add_shape(spec, shape)

    def reset(self, world: World, variation: int) -> None:
        rng = world.rng
        self.variation, self.shape = variation, SHAPES[variation]
        self.description = str(rng.choice(_WORDINGS)).format(self.shape.name)
        sorter, positions = layout(rng)
        world.place(shape_sorter.BODY, sorter)
        for shape, position, yaw in zip(SHAPES, positions, rng.uniform(-_YAW, _YAW, len(SHAPES)), strict=True):
            world.place(shape.body, Pose(np.array((*position, 0.0)), Rotation.from_euler("z", yaw).as_quat()))

    def success(self, world: World) -> bool:
        position = world.pose(shape_sorter.BODY).inverse().apply(world.pose(self.shape.body).position)
        below = position[2] < PLATE_BOTTOM - 1.4 * BODY_HEIGHT
        inside = shape_sorter.COMPARTMENTS[self.shape.name].contains(position)
        return bool(below and inside and not world.holds(self.shape.body))

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        held = world.held_bodies()
        for shape in SHAPES:
            if shape is not self.shape and shape.body in held:
                return self._put_back(world, shape, world.tool) + self._fetch(world, self.shape)
        blocker = self._blocker(world)
        if self.shape.body in held:
            return self._put_back(world, self.shape, world.tool) if blocker else self._bring(world, world.tool)
        return self._fetch(world, blocker) if blocker else self._fetch(world, self.shape)

    def _blocker(self, world: World) -> Shape | None:
        """Another shape that lies on the hole."""
        sorter = world.pose(shape_sorter.BODY)
        position = sorter.apply(np.array((*shape_sorter.hole(self.shape), PLATE_TOP)))
        for shape in SHAPES:
            away = world.pose(shape.body).position - position
            if shape is not self.shape and np.hypot(*away[:2]) < 0.045 and abs(away[2]) < 0.03:
                return shape
        return None

    def _fetch(self, world: World, shape: Shape) -> list[Waypoint]:
        """All steps, or those from the grasp on where the hand waits above the shape."""
        grasp = self._grasp(world, shape)
        before = grasp.shifted(z=_APPROACH)
        steps = grasping(world, before, grasp, "top", f"the {shape.name}", spin=_SPIN)
        return steps + (self._bring(world, grasp) if shape is self.shape else self._put_back(world, shape, grasp))

    def _grasp(self, world: World, shape: Shape) -> Pose:
        """The hand around the shape's bar; where something is in the way of a finger, turned or off centre."""
        pose = world.pose(shape.body)
        axes = pose.rotation.as_matrix()
        point, sorter = pose.apply(np.array((0.0, 0.0, GRIP))), world.pose(shape_sorter.BODY)
        floor = PLATE_TOP if over_sorter(point, sorter) else 0.0
        point[2] = max(point[2], floor + _FINGERTIP)
        others = self._others(world, shape)
        # Across the bar; of a shape that leans, across its more level axis.
        leans = axes[2, 2] < np.cos(_LYING)
        x, y, _ = min((axes[:, 1], axes[:, 0]), key=lambda side: abs(side[2])) if leans else axes[:, 1]
        yaws = np.arctan2(-x, y) + (_TURNS[:1] if leans else _TURNS)
        hands = [Pose(point, top_down(float(yaw))) for yaw in yaws]
        grasps = [
            Pose(hand.apply(np.array((0.0, step, 0.0))), hand.quaternion) for step in _SIDESTEPS for hand in hands
        ]
        return next((grasp for grasp in grasps if has_room(grasp, others, sorter)), grasps[0])

    def _bring(self, world: World, tool: Pose) -> list[Waypoint]:
        """The steps that remain for the shape, held as it would be by a hand at ``tool``."""
        pose = world.pose(self.shape.body)
        grip = tool.inverse() @ pose
        if _tilt(Rotation.from_quat(DOWN) * grip.rotation) > _LYING:
            return self._put_back(world, self.shape, tool)
        over = self._to_hole(world, _OVER, grip)
        into = self._to_hole(world, -_INTO, grip)
        thing = f"the {self.shape.name}"
        steps = [
            _raised(tool),
            Waypoint(over, False, False, instruct("align", f"{thing} hole")),
            Waypoint(into, False, True, instruct("insert", thing, "the shape sorter")),
            release(into, thing),
        ]
        sideways = np.linalg.norm((pose.position - (into @ grip).position)[:2])
        turned = tool.distance(into)[1]
        if sideways < _IN and turned < _TURNED and pose.position[2] < PLATE_TOP - 0.002:
            return steps[3:]
        if sideways < _ARRIVED and points_alike(tool, into, _FITTING) and pose.position[2] < PLATE_TOP + 2 * _OVER:
            return steps[2:]
        return steps[1:] if tool.position[2] > _CARRY - 0.03 else steps

    def _to_hole(self, world: World, height: float, grip: Pose) -> Pose:
        """The hand's pose that brings the shape, held at ``grip``, to a height above its hole, turned to fit."""
        sorter = world.pose(shape_sorter.BODY)
        position = sorter.apply(np.array((*shape_sorter.hole(self.shape), PLATE_TOP + height)))
        down = Rotation.from_quat(DOWN)
        turn = _yaw(sorter.rotation)
        if self.shape.fold:
            # Of the turns that fit, the one nearest to the middle of the wrist's range.
            period = 2 * np.pi / self.shape.fold
            turn = (turn - _yaw(down * grip.rotation) + period / 2) % period - period / 2
        hand = Rotation.from_euler("z", turn) * down
        tilt = _righting(hand * grip.rotation)
        if tilt.magnitude() > _UPRIGHT:
            hand = tilt * hand
        return Pose(position - hand.apply(grip.position), hand.as_quat())

    def _put_back(self, world: World, shape: Shape, tool: Pose) -> list[Waypoint]:
        """The steps that put a shape, held as it would be by a hand at ``tool``, on the table, as upright as can be."""
        pose, sorter = world.pose(shape.body), world.pose(shape_sorter.BODY)
        grip = tool.inverse() @ pose
        positions = free_positions(pose.position[:2], self._others(world, shape)[:, :2], sorter)[:_NEAREST]
        # Where the hand was turned by what it does with a lying shape, the yaw is the one it has.
        hand = Rotation.from_euler("z", _yaw(tool.rotation)) * Rotation.from_quat(DOWN)
        righting = _righting(hand * grip.rotation).as_rotvec()
        angle = float(np.linalg.norm(righting))
        goals = []
        for lean in _LEANS if angle > _UPRIGHT else _LEANS[-1:]:
            turned = Rotation.from_rotvec(righting * min(1.0, lean / angle) if angle else righting) * hand
            height = 0.006 - extent(shape, turned * grip.rotation)
            offset = turned.apply(grip.position)
            goals += [Pose(np.array((*position, height)) - offset, turned.as_quat()) for position in positions]
        goal = next((goal for goal in goals if _has_path(world, goal)), goals[0]) if world.held_bodies() else goals[0]
        thing = f"the {shape.name}"
        steps = [
            _raised(tool),
            Waypoint(goal, False, False, instruct("place", thing, "the table")),
            release(goal, thing),
        ]
        distance, turn = tool.distance(goal)
        if distance < _PUT and turn < _TURNED:
            return steps[2:]
        return steps[1:] if tool.position[2] > _CARRY - 0.03 else steps

    @staticmethod
    def _others(world: World, shape: Shape) -> np.ndarray:
        """(4, 3) origins of the other shapes."""
        return np.array([world.pose(other.body).position for other in SHAPES if other is not shape])


def _has_path(world: World, goal: Pose) -> bool:
    """Whether the arm reaches a pose with what it holds."""
    try:
        world.planner.plan(world.data, goal, False, world.carried(), np.random.default_rng(0))
    except PlanningError:
        return False
    return True


def _raised(tool: Pose) -> Waypoint:
    return Waypoint(tool.shifted(z=_CARRY - tool.position[2]), False, True, instruct("raise"))


def _yaw(rotation: Rotation) -> float:
    """Heading of the x axis."""
    x, y, _ = rotation.apply((1.0, 0.0, 0.0))
    return float(np.arctan2(y, x))


def _tilt(rotation: Rotation) -> float:
    """Radians between a thing's z axis and the vertical."""
    return float(np.arccos(np.clip(rotation.apply((0.0, 0.0, 1.0))[2], -1.0, 1.0)))


def _righting(rotation: Rotation) -> Rotation:
    """The smallest turn, in the base frame, that makes a thing's z axis vertical."""
    axis = rotation.apply((0.0, 0.0, 1.0))
    across = np.cross(axis, (0.0, 0.0, 1.0))
    length = np.linalg.norm(across)
    return Rotation.from_rotvec(across / length * _tilt(rotation)) if length > 1e-9 else Rotation.identity()
