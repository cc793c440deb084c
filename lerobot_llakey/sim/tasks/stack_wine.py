"""Stack a bottle in a slot of the wine rack: one wording, three action sequences.

The red bottle lies the way it has to lie in the rack, the green one stands and must be tipped, the yellow one lies the
wrong way round and must be turned end for end. All three are there in every scene.
"""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import DOWN, Pose
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.objects.wine import (
    LYING_HEIGHT,
    MIDDLE,
    SLOTS,
    add_bottle,
    add_bottle_meshes,
    add_rack,
    on_beam,
    slot_y,
)
from lerobot_llakey.sim.objects.wine_placements import LYING_GRIP, SIDE, draw_placements
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

BOTTLES = {"red": (0.75, 0.06, 0.10, 1.0), "green": (0.07, 0.50, 0.17, 1.0), "yellow": (0.95, 0.78, 0.12, 1.0)}
_UPRIGHT_GRIP, _OTHER_GRIPS = 0.095, (0.045, 0.100, 0.020)
"""Metres from a bottle's bottom to where a hand takes it standing, and lying with the rack in the fingers' way."""
_FINGERS = np.array(((0.0, 0.045, 0.012), (0.0, -0.045, 0.012)))
"""(2, 3) metres: where the tips of the open fingers are in the tool's frame."""
_SHORT = 0.006
"""Metres by which the hand stays short of a bottle's axis, so that it clears the rack."""
_ABOVE, _BESIDE, _CARRY = 0.12, 0.10, 0.22
"""Metres before the grasp of a lying and of a standing bottle, and height of the hand while it carries one."""
_LOWER = np.deg2rad(-75)
"""Least yaw of a hand that takes a lying bottle; the half turn from there leaves joint 7 the way to turn on."""
_FIRST_YAW = np.deg2rad(-118)
"""Yaw from which the hand's turns are counted: between where it may take a bottle and where it may lay it down."""
_FAR_TURN, _TURN = np.deg2rad(120), np.deg2rad(60)
"""Radians of turn that need a stop half-way, and that need a turn of their own before the slot."""
_LOW, _ARRIVED, _PUT, _TURNED = 0.05, 0.03, 0.016, 0.35
"""How far (metres, and radians) a hand may be off and still be high enough to carry, above its slot or down in it."""
_STANDS, _HANGS = np.sin(np.deg2rad(45)), np.sin(np.deg2rad(50))
"""Rise of a bottle's axis from which it counts as standing, and as hanging along the hand that holds it."""
_LEAN = np.deg2rad(25)
"""Radians by which the hand leans at most, to level a bottle that it holds askew."""
_DROP = 0.003
"""Metres above its cradle at which a bottle is let go."""
_REACH = np.array((0.03, 0.012, 0.008))
"""Metres by which a bottle in its slot may miss the middle, along the rack's axes."""
_ASKEW = np.cos(np.deg2rad(10))


class StackWine(Task):
    """Nine variations, bottle by slot; three sequences, one for each bottle."""

    name: ClassVar[str] = "stack_wine"
    variations: ClassVar[int] = 9
    sequences: ClassVar[int] = 3

    def build(self, spec: mujoco.MjSpec) -> None:
        add_bottle_meshes(spec)
        for colour, rgba in BOTTLES.items():
            add_bottle(spec, colour, rgba)
        add_rack(spec, "rack")

    def reset(self, world: World, variation: int) -> None:
        self.variation = variation
        self.sequence, slot = divmod(variation, len(SLOTS))
        self.colour, self.slot = tuple(BOTTLES)[self.sequence], SLOTS[slot]
        self.description = f"stack the {self.colour} wine bottle to the {self.slot} of the rack"
        for body, pose in zip(("rack", *BOTTLES), draw_placements(world.rng), strict=True):
            world.place(body, pose)

    def success(self, world: World) -> bool:
        bottle = world.pose("rack").inverse() @ world.pose(self.colour)
        miss = bottle.apply(_along(MIDDLE)) - (0, slot_y(self.slot), LYING_HEIGHT)
        straight = bottle.rotation.as_matrix()[0, 2] > _ASKEW
        return bool(straight and (np.abs(miss) < _REACH).all() and not world.holds(self.colour))

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        tool, bottle = world.tool, world.pose(self.colour)
        held = world.held_bodies() & set(BOTTLES)
        wrong = [release(tool, f"the {colour} wine bottle") for colour in sorted(held - {self.colour})]
        if self.colour not in held:
            fetch, grasp = self._fetch(world, bottle)
            return wrong + fetch + self._bring(world, grasp, bottle)
        if abs((tool.inverse() @ bottle).rotation.as_matrix()[2, 2]) > _HANGS:
            return [*wrong, release(tool, self._thing)]
        return wrong + self._bring(world, tool, bottle)

    @property
    def _thing(self) -> str:
        return f"the {self.colour} wine bottle"

    def _fetch(self, world: World, bottle: Pose) -> tuple[list[Waypoint], Pose]:
        """The way to the grasp, and the tool's pose there."""
        axis = bottle.rotation.as_matrix()[:, 2]
        if abs(axis[2]) > _STANDS:
            height = _UPRIGHT_GRIP if axis[2] > 0 else LYING_GRIP
            grasp = Pose(bottle.apply(_along(height)), _sideways(SIDE)).advanced(-_SHORT)
            before, side = grasp.advanced(-_BESIDE), "right side"
        else:
            yaw = _LOWER + (np.arctan2(axis[1], axis[0]) - _LOWER) % np.pi
            grasps = [
                Pose(bottle.apply(_along(height)), _down(yaw)).shifted(z=_SHORT)
                for height in (LYING_GRIP, *_OTHER_GRIPS)
            ]
            to_rack = world.pose("rack").inverse()
            clear = (grasp for grasp in grasps if not on_beam(to_rack.apply(grasp.apply(_FINGERS))))
            grasp = next(clear, grasps[0])
            before, side = grasp.shifted(z=_ABOVE), "top"
        return grasping(world, before, grasp, side, self._thing), grasp

    def _bring(self, world: World, tool: Pose, bottle: Pose) -> list[Waypoint]:
        """Up, turned as it must lie, above the slot, down into it, let go; for a bottle in a hand at ``tool``."""
        rack = world.pose("rack")
        heading = float(np.arctan2(*rack.rotation.as_matrix()[1::-1, 0]))
        goal = rack.apply(np.array((0, slot_y(self.slot), LYING_HEIGHT + _DROP)))
        grip = tool.inverse() @ bottle
        sign = 1.0 if grip.rotation.as_matrix()[0, 2] > 0 else -1.0
        final = heading if sign > 0 else heading + np.pi
        level = _levelled(grip, sign, final)
        put = Pose(goal - level.apply(grip.apply(_along(MIDDLE))), level.as_quat())
        above = _at_carry(put)
        steps = []
        there = np.linalg.norm((tool.position - put.position)[:2]) < _ARRIVED and tool.distance(put)[1] < _TURNED
        if not there:
            if tool.position[2] < _CARRY - _LOW:
                tool = _at_carry(tool)
                steps.append(Waypoint(tool, False, True, instruct("raise")))
            position, hand = np.array((*tool.position[:2], _CARRY)), tool.rotation
            if abs(bottle.rotation.as_matrix()[2, 2]) > _STANDS:
                hand = _levelled(grip, sign, heading)
                steps.append(self._turn(Pose(position, hand.as_quat()), "the lying pose"))
            left = final - _yaw(hand)
            if abs(left) > _FAR_TURN:
                left = np.copysign(np.pi / 2, left)
                crosswise = _levelled(grip, sign, final - left)
                steps.append(self._turn(Pose(position, crosswise.as_quat()), "the crosswise direction"))
            if abs(left) > _TURN:
                steps.append(self._turn(Pose(position, level.as_quat()), "the rack direction"))
            steps.append(Waypoint(above, False, False, instruct("move", "top", f"the {self.slot} slot")))
        place = Waypoint(put, False, True, instruct("place", self._thing, f"the {self.slot} slot"))
        let_go = release(put, self._thing)
        distance, angle = tool.distance(put)
        return [*steps, let_go] if distance < _PUT and angle < _TURNED else [*steps, place, let_go]

    def _turn(self, pose: Pose, direction: str) -> Waypoint:
        return Waypoint(pose, False, False, instruct("rotate", self._thing, direction))


def _along(length: float) -> np.ndarray:
    """(3,) a point on a bottle's axis, metres from its bottom."""
    return np.array((0.0, 0.0, length))


def _at_carry(tool: Pose) -> Pose:
    return Pose(np.array((*tool.position[:2], _CARRY)), tool.quaternion)


def _down(yaw: float) -> np.ndarray:
    """Quaternion of a hand that points down with its x axis along ``yaw``, any yaw up to a full turn."""
    return (Rotation.from_euler("z", yaw) * Rotation.from_quat(DOWN)).as_quat()


def _sideways(yaw: float) -> np.ndarray:
    """Quaternion of a hand that points level along ``yaw``, its x axis up."""
    return (Rotation.from_euler("ZY", (yaw, -np.pi / 2)) * Rotation.from_quat(DOWN)).as_quat()


def _yaw(hand: Rotation) -> float:
    """Yaw of the hand's x axis, counted on past half a turn on the side to which joint 7 can turn it."""
    x, y, _ = hand.as_matrix()[:, 0]
    return float(_FIRST_YAW + (np.arctan2(y, x) - _FIRST_YAW) % (2 * np.pi))


def _levelled(grip: Pose, sign: float, yaw: float) -> Rotation:
    """Rotation of a hand that points down along ``yaw``, leant so that the bottle at ``grip`` in it lies level.

    ``sign`` says whether the bottle's neck points along the hand's x axis or against it.
    """
    down = Rotation.from_quat(_down(yaw))
    wanted = sign * np.array((np.cos(yaw), np.sin(yaw), 0.0))
    axis = down.apply(grip.rotation.as_matrix()[:, 2])
    turn = np.cross(axis, wanted)
    sine = float(np.linalg.norm(turn))
    angle = min(float(np.arctan2(sine, axis @ wanted)), _LEAN)
    return Rotation.from_rotvec(angle * turn / max(sine, 1e-9)) * down
