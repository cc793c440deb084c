"""Put a light bulb in a box: one wording, two action sequences.

Red and yellow bulbs are screwed into sockets and must be screwed out first; blue, green and white ones stand loose.
Everything is there in every scene, so what to do follows from the words and the picture together.
"""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.arm.grasps import Grasp, hand_yaw
from lerobot_llakey.sim.arm.panda import ARM_CONTYPE
from lerobot_llakey.sim.objects.bulb import (
    ANGLE,
    GLASS_HEIGHT,
    TRAVEL,
    add_bulb,
    add_bulb_meshes,
    add_socket,
    facing,
    glass_middle,
)
from lerobot_llakey.sim.objects.screw_thread import ScrewThread
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

LOOSE, SCREWED = range(2)
_BULBS = {
    "red": (0.85, 0.10, 0.10),
    "yellow": (0.95, 0.85, 0.10),
    "blue": (0.10, 0.25, 0.90),
    "green": (0.10, 0.65, 0.20),
    "white": (0.93, 0.93, 0.93),
}
_SCREWED = ("red", "yellow")
_BOXES = {"purple": (0.50, 0.10, 0.60), "orange": (1.00, 0.50, 0.05)}
_STONE = (0.22, 0.23, 0.26, 1.0)
_SEAT, _PLATE = 0.022, 0.008
"""Heights of the tip of a screwed bulb above the table, and of the plate that a socket stands on. Metres."""
_INSIDE, _WALL, _WALL_HEIGHT, _FLOOR = 0.062, 0.004, 0.045, 0.004
"""Half a box's inner width, its walls' thickness and height, its floor's thickness. Metres: the walls stay below the
fingertips, so that a bulb can be taken out again."""
_ABOVE_MIDDLE = 0.002
_GRASP = GLASS_HEIGHT + _ABOVE_MIDDLE
"""Metres of a grasp above the middle of the glass, and above the tip of an upright bulb."""
_ABOVE, _CARRY = 0.10, 0.125
"""Metres from the grasp to the hand before it, and height of the tip of a carried bulb: higher than all the others."""
_YAW = np.deg2rad(55)
"""The hand is turned to one side to carry, to the other one to screw out: joint 7 allows one turn between them."""
_ARRIVED = 0.035
"""Metres by which a bulb may be off beside the middle of its box."""
_LOW = 0.03
"""Metres by which a hand may carry low."""
_JITTER = 0.01
_CORNERS = ((0.41, -0.26), (0.41, 0.26), (0.57, -0.26), (0.57, 0.26))
_MIDDLE = ((0.47, -0.12), (0.47, 0.0), (0.47, 0.12), (0.60, -0.12), (0.60, 0.0), (0.60, 0.12))
"""Places; both boxes stand in corners, and what is left of the corners is as good as the middle for bulbs."""


class PutBulb(Task):
    """Ten variations, five bulbs times two boxes; two sequences; the places of everything vary."""

    name: ClassVar[str] = "put_bulb"
    variations: ClassVar[int] = len(_BULBS) * len(_BOXES)
    sequences: ClassVar[int] = 2

    def __init__(self) -> None:
        self.threads = {colour: ScrewThread(f"{colour}_socket", f"{colour}_bulb", TRAVEL, ANGLE) for colour in _SCREWED}

    def build(self, spec: mujoco.MjSpec) -> None:
        add_bulb_meshes(spec)
        for colour, rgb in _BULBS.items():
            add_bulb(spec, f"{colour}_bulb", glass=(*rgb, 1.0), collar=(*rgb, 1.0))
        for colour, thread in self.threads.items():
            socket = spec.worldbody.add_body(name=f"{colour}_socket")
            size = (0.032, 0.032, _PLATE / 2)
            socket.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=(0, 0, _PLATE / 2), rgba=_STONE)
            _add_body(socket)
            add_socket(socket, _SEAT)
            thread.add(spec, socket, (0, 0, _SEAT + TRAVEL), 0.0)
        for colour, rgb in _BOXES.items():
            _add_box(spec.worldbody.add_body(name=f"{colour}_box"), (*rgb, 1.0))

    def reset(self, world: World, variation: int) -> None:
        self.variation = variation
        bulb, box = divmod(variation, len(_BOXES))
        self.colour, self.box = tuple(_BULBS)[bulb], tuple(_BOXES)[box]
        self.bulb = f"{self.colour}_bulb"
        self.thread = self.threads.get(self.colour)
        self.sequence = SCREWED if self.thread else LOOSE
        self.description = f"put the {self.colour} light bulb in the {self.box} box"
        rng = world.rng
        corners = rng.permutation(np.array(_CORNERS))
        positions = rng.permutation(np.concatenate((corners[2:], _MIDDLE)))
        for colour, position in zip(_BOXES, corners, strict=False):
            world.place(f"{colour}_box", _at(rng, position))
        for colour, position in zip(_BULBS, positions, strict=False):
            pose = _at(rng, position)
            if colour in self.threads:
                world.place(f"{colour}_socket", pose)
                self.threads[colour].start_in(world)
            else:
                world.place(f"{colour}_bulb", Pose(pose.position, facing(_YAW)))

    def before_step(self, world: World) -> None:
        for thread in self.threads.values():
            thread.before_step(world)

    def success(self, world: World) -> bool:
        offset = world.pose(f"{self.box}_box").inverse().apply(world.pose(self.bulb).position)
        inside = np.abs(offset[:2]).max() < _INSIDE and offset[2] < _WALL_HEIGHT
        return bool(inside and not world.holds(self.bulb))

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        held = world.held_bodies()
        if self.bulb in held:
            return self._carry(world)
        wrong = [colour for colour in _BULBS if f"{colour}_bulb" in held]
        drop = [release(world.tool, f"the {colour} light bulb") for colour in wrong]
        return drop + self._fetch(world)

    @property
    def _thing(self) -> str:
        return f"the {self.colour} light bulb"

    def _engaged(self, world: World) -> bool:
        return self.thread is not None and self.thread.engaged(world)

    def _fetch(self, world: World) -> list[Waypoint]:
        """All steps, or those from the grasp on where the hand waits above the bulb."""
        engaged = self._engaged(world)
        middle = glass_middle(world.pose(self.bulb))
        grasp = Pose(middle, top_down(-_YAW if engaged else _YAW)).shifted(z=_ABOVE_MIDDLE)
        before = grasp.shifted(z=_ABOVE)
        return (
            grasping(world, before, grasp, "top", self._thing)
            + self._bring(world, Grasp.upright(_GRASP))[not engaged :]
        )

    def _bring(self, world: World, grip: Grasp) -> list[Waypoint]:
        """The steps for a bulb held as given: out of its socket, up, over the box, let go."""
        here, box = world.tool if world.holds(self.bulb) else world.pose(self.bulb), world.pose(f"{self.box}_box")
        socket = world.pose(f"{self.colour}_socket").position if self.thread else here.position
        out = grip.hand(np.array((*socket[:2], _SEAT + TRAVEL)), _YAW)
        raised, over = (Pose(np.array((*place.position[:2], _CARRY + _GRASP)), top_down(_YAW)) for place in (here, box))
        return [
            Waypoint(out, False, True, instruct("screw_out", self._thing)),
            Waypoint(raised, False, True, instruct("raise")),
            Waypoint(over, False, False, instruct("move", "top", f"the {self.box} box")),
            release(over, self._thing),
        ]

    def _carry(self, world: World) -> list[Waypoint]:
        """The steps that remain for the bulb in the hand."""
        tool, bulb = world.tool, world.pose(self.bulb)
        steps = self._bring(world, Grasp.of(tool, bulb))
        let_go = release(tool, self._thing)
        if self._engaged(world):
            # A hand that turned all the way must take the bulb anew.
            return steps if hand_yaw(tool) < _YAW - 0.2 else [let_go]
        beside = np.hypot(*(tool.position - world.pose(f"{self.box}_box").position)[:2])
        if tool.position[2] < _CARRY + _GRASP - _LOW:
            return steps[1:]
        return [let_go] if beside < _ARRIVED else steps[2:]


def _at(rng: np.random.Generator, position: np.ndarray) -> Pose:
    return Pose(np.array((*(position + rng.uniform(-_JITTER, _JITTER, 2)), 0.0)))


def _add_body(socket: mujoco.MjsBody) -> None:
    """What one sees below the ring that holds the bulb."""
    half = (_SEAT - _PLATE) / 2
    size, place = (0.024, half, 0), (0, 0, _PLATE + half)
    socket.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, pos=place, rgba=_STONE, contype=0, conaffinity=ARM_CONTYPE
    )


def _add_box(box: mujoco.MjsBody, colour: tuple[float, float, float, float]) -> None:
    """A floor and four walls, open at the top."""
    outer, kind = _INSIDE + 2 * _WALL, mujoco.mjtGeom.mjGEOM_BOX
    box.add_geom(type=kind, size=(outer, outer, _FLOOR / 2), pos=(0, 0, _FLOOR / 2), rgba=colour)
    half = (_WALL_HEIGHT - _FLOOR) / 2
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        box.add_geom(
            type=kind,
            size=(_WALL, outer, half) if x else (_INSIDE, _WALL, half),
            pos=(x * (_INSIDE + _WALL), y * (_INSIDE + _WALL), _FLOOR + half),
            rgba=colour,
            friction=(0.3, 0.005, 0.0001),
        )
