"""Screw the light bulb from the holder of the named colour into the lamp (RLBench's ``light_bulb_in``)."""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.arm.grasps import MOST_TILT, Grasp, hand_yaw
from lerobot_llakey.sim.objects.bulb import (
    ANGLE,
    GLASS_HEIGHT,
    TRAVEL,
    add_bulb,
    add_bulb_meshes,
    facing,
    glass_middle,
)
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES, COLOURS
from lerobot_llakey.sim.objects.lamp import HOLDER_HEIGHT, SEAT, add_holder, add_lamp, paint_holder, switch
from lerobot_llakey.sim.objects.placements import three_placements
from lerobot_llakey.sim.objects.screw_thread import ScrewThread
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

_WORDINGS = (
    "screw in the {} light bulb",
    "screw the light bulb from the {} holder into the lamp",
    "pick up the light bulb from the {} stand, lift it up to just above the lamp, then screw it down into the lamp in "
    "a clockwise fashion",
    "put the light bulb from the {} casing into the lamp",
)
_BULBS, _HOLDERS = ("bulb", "other_bulb"), ("holder", "other_holder")
_GLASS = (0.72, 0.76, 0.80, 1.0)
_SCREWED = np.deg2rad(75)
"""Radians of turn that count as screwed in; the lamp lights up there."""
_ABOVE_MIDDLE = 0.002
_GRASP = GLASS_HEIGHT + _ABOVE_MIDDLE
"""Metres of a grasp above the middle of the glass, and above the tip of an upright bulb."""
_ABOVE, _CARRY = 0.10, 0.12
"""Metres from the grasp to the hand before it, and height of a carried bulb's tip."""
_ENTRY, _PRESS = SEAT + TRAVEL, 0.003
"""Height of the tip on the first turn of the thread; metres by which the hand aims below."""
_YAW = np.deg2rad(55)
"""The hand is turned to one side from the start, so that one turn to the other side, within joint 7, is enough."""
_OVER, _TURNED = 0.016, 0.3
"""Metres beside the lamp, and radians, from which a bulb is set down on it: the next action corrects them."""
_X, _Y, _REACH = (0.34, 0.63), (-0.31, 0.31), (0.45, 0.68)
"""Metres: where things stand, and how far from the base, so that a hand that points down reaches them."""
_HOLDER_GAP, _LAMP_GAP = 0.15, 0.16
_FALLBACK = ((0.50, 0.2), (0.50, 0.0), (0.50, -0.2))


class LightBulbIn(Task):
    """Twenty variations, one for each colour; beside the bulb's holder stands one of another colour.

    A band around a bulb's neck has its holder's colour, so that a bulb is known again wherever it went.
    """

    name: ClassVar[str] = "light_bulb_in"
    variations: ClassVar[int] = len(COLOURS)

    def __init__(self) -> None:
        self.threads = tuple(ScrewThread(f"lamp_{bulb}", bulb, TRAVEL, ANGLE) for bulb in _BULBS)

    def build(self, spec: mujoco.MjSpec) -> None:
        add_bulb_meshes(spec)
        lamp = add_lamp(spec, "lamp")
        for bulb, holder, thread in zip(_BULBS, _HOLDERS, self.threads, strict=True):
            add_bulb(spec, bulb, glass=_GLASS, collar=_GLASS)
            add_holder(spec, holder)
            thread.add(spec, lamp, (0, 0, SEAT + TRAVEL), 0.0)
        # Each thread carries its own bulb alone: the other one would stand on an idle nut.
        for bulb, thread in zip(_BULBS, reversed(self.threads), strict=True):
            spec.add_exclude(bodyname1=f"{thread.name}_nut", bodyname2=bulb)

    def reset(self, world: World, variation: int) -> None:
        rng = world.rng
        self.variation = variation
        other = (variation + int(rng.integers(1, self.variations))) % self.variations
        self.colours = COLOUR_NAMES[variation], COLOUR_NAMES[other]
        self.description = str(rng.choice(_WORDINGS)).format(self.colours[0])
        lamp, *positions = three_placements(rng, _X, _Y, _REACH, (_LAMP_GAP, _LAMP_GAP, _HOLDER_GAP), _FALLBACK)
        world.place("lamp", Pose(np.array((*lamp, 0.0))))
        for bulb, holder, colour, position in zip(_BULBS, _HOLDERS, self.colours, positions, strict=True):
            world.place(holder, Pose(np.array((*position, 0.0))))
            world.place(bulb, Pose(np.array((*position, 0.0)), facing(_YAW)))
            paint_holder(world, holder, COLOURS[colour])
            world.paint(f"{bulb}_collar", COLOURS[colour])

    def before_step(self, world: World) -> None:
        for thread in self.threads:
            thread.before_step(world)
        switch(world, "lamp", any(thread.turned(world) >= _SCREWED for thread in self.threads))

    def success(self, world: World) -> bool:
        return self.threads[0].turned(world) >= _SCREWED and not world.holds("bulb")

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        held = world.held_bodies()
        blocked = _in_lamp(world, "other_bulb")
        if "other_bulb" in held:
            return self._put_away(world) + self._fetch(world)
        if "bulb" not in held:
            return (self._clear(world) if blocked else []) + self._fetch(world)
        if blocked:
            return [self._release(world.tool, 0), *self._clear(world), *self._fetch(world)]
        return self._turn(world) if self.threads[0].seated(world) else self._carry(world)

    def _bulb_name(self, index: int) -> str:
        return f"the {self.colours[index]} light bulb"

    def _take(self, world: World, index: int, yaw: float) -> list[Waypoint]:
        """Both steps of a grasp, or the second where the hand waits above the bulb."""
        grasp = Pose(glass_middle(world.pose(_BULBS[index])), top_down(yaw)).shifted(z=_ABOVE_MIDDLE)
        return grasping(world, grasp.shifted(z=_ABOVE), grasp, "top", self._bulb_name(index))

    def _fetch(self, world: World) -> list[Waypoint]:
        bring = self._bring(world, Grasp.upright(_GRASP))
        return self._take(world, 0, _YAW) + bring[3 * self.threads[0].seated(world) :]

    def _bring(self, world: World, grip: Grasp) -> list[Waypoint]:
        """The steps from the raise on, for a bulb held as given."""
        (x, y, _), name = world.pose("lamp").position, self._bulb_name(0)
        aligned = grip.hand(np.array((x, y, _CARRY)), _YAW)
        placed = grip.hand(np.array((x, y, _ENTRY - _PRESS)), _YAW)
        screwed = grip.hand(np.array((x, y, SEAT - _PRESS)), -_YAW)
        return [
            self._raised(world, 0),
            Waypoint(aligned, False, False, instruct("align", "the lamp")),
            Waypoint(placed, False, True, instruct("place", name, "the lamp")),
            Waypoint(screwed, False, True, instruct("screw_in", name)),
            self._release(screwed, 0),
        ]

    def _carry(self, world: World) -> list[Waypoint]:
        """The steps that remain for the bulb in the hand and off the lamp."""
        grip = Grasp.of(world.tool, world.pose("bulb"))
        steps = self._bring(world, grip)
        beside, _, height = _from_lamp(world, "bulb")
        if beside < _OVER and abs(hand_yaw(world.tool) - _YAW) < _TURNED and height > -0.005:
            return steps[2:]
        if world.tool.position[2] < _CARRY + _GRASP - 0.035:
            return steps
        # A bulb that lies across the hand is let fall: it rights itself.
        return [self._release(world.tool, 0)] if grip.tilt > MOST_TILT else steps[1:]

    def _turn(self, world: World) -> list[Waypoint]:
        """The steps that remain for the bulb in the hand and on its thread."""
        if self.threads[0].turned(world) >= _SCREWED or hand_yaw(world.tool) < 0.2 - _YAW:
            return [self._release(world.tool, 0)]
        return self._bring(world, Grasp.of(world.tool, world.pose("bulb")))[3:]

    def _clear(self, world: World) -> list[Waypoint]:
        """Take the other bulb out of the lamp."""
        engaged = self.threads[1].engaged(world)
        take = self._take(world, 1, -_YAW if engaged else _YAW)
        return [*take, *self._away(world, Grasp.upright(_GRASP))[not engaged :]]

    def _put_away(self, world: World) -> list[Waypoint]:
        """The steps that remain for the other bulb in the hand."""
        let_go = self._release(world.tool, 1)
        steps = self._away(world, Grasp.of(world.tool, world.pose("other_bulb")))
        if self.threads[1].engaged(world):
            return steps if hand_yaw(world.tool) < _YAW - 0.2 else [let_go]
        if _in_lamp(world, "other_bulb"):
            return steps[1:]
        beside, _, _ = _from_lamp(world, "other_bulb")
        return steps[2:] if beside < _LAMP_GAP / 2 else [let_go]

    def _away(self, world: World, grip: Grasp) -> list[Waypoint]:
        """Screw the other bulb out, raise it and let it down on its holder."""
        (x, y, _), (lamp_x, lamp_y, _) = world.pose("other_holder").position, world.pose("lamp").position
        name, holder = self._bulb_name(1), f"the {self.colours[1]} holder"
        out = grip.hand(np.array((lamp_x, lamp_y, _ENTRY)), _YAW)
        over = grip.hand(np.array((x, y, HOLDER_HEIGHT)), _YAW)
        return [
            Waypoint(out, False, True, instruct("screw_out", name)),
            self._raised(world, 1),
            Waypoint(over, False, False, instruct("move", "top", holder)),
            self._release(over, 1),
        ]

    @staticmethod
    def _raised(world: World, index: int) -> Waypoint:
        """Straight up from the bulb, taken or to be taken."""
        x, y, _ = (world.tool if world.holds(_BULBS[index]) else world.pose(_BULBS[index])).position
        return Waypoint(Pose(np.array((x, y, _CARRY + _GRASP)), top_down(_YAW)), False, True, instruct("raise"))

    def _release(self, pose: Pose, index: int) -> Waypoint:
        return release(pose, self._bulb_name(index))


def _from_lamp(world: World, bulb: str) -> tuple[float, float, float]:
    """Metres of a bulb's tip beside the lamp's axis, above the table, and above the thread's first turn."""
    tip = world.pose(bulb).position
    beside = np.hypot(*(tip - world.pose("lamp").position)[:2])
    return float(beside), float(tip[2]), float(tip[2]) - _ENTRY


def _in_lamp(world: World, bulb: str) -> bool:
    beside, height, above = _from_lamp(world, bulb)
    return beside < 0.012 and height > SEAT - 0.005 and above < 0.01
