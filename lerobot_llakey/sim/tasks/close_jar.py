"""Screw the lid on the jar of the named colour (RLBench's ``close_jar``)."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import mujoco
import numpy as np

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.arm.grasps import Grasp, hand_yaw
from lerobot_llakey.sim.objects.colours import COLOUR_NAMES, COLOURS
from lerobot_llakey.sim.objects.jar import JAR_PARTS, JAR_TOP, LID_DEPTH, add_jar, add_jar_tip, add_lid
from lerobot_llakey.sim.objects.placements import three_placements
from lerobot_llakey.sim.objects.screw_thread import ScrewThread
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

_WORDINGS = (
    "close the {} jar",
    "screw on the {} jar lid",
    "grasping the lid, lift it from the table and use it to seal the {} jar",
    "pick up the lid from the table and put it on the {} jar",
)
_JARS = ("jar", "other_jar")
_TRAVEL, _ANGLE = 0.008, np.deg2rad(105)
_ENTRY = JAR_TOP + 0.001 + _TRAVEL - LID_DEPTH
"""Height of the lid's rim above the table on the first turn of the thread."""
_CLOSED = np.deg2rad(75)
"""Radians of turn that count as closed."""
_GRASP = 0.020
"""Height of the fingertips above the lid's rim."""
_ABOVE, _CARRY = 0.10, 0.19
"""Metres from the lid to the hand before it grasps, and height of the hand while it carries the lid."""
_PRESS = 0.003
"""Metres by which the hand aims below the thread, so that a lid held a little low in the hand still sits on it."""
_PUT = 0.008
"""Metres from its place within which a hand has put the lid down."""
_YAW = np.deg2rad(55)
"""The hand is turned to one side from the start, so that one turn to the other side, within joint 7, is enough."""
_X, _Y, _REACH = (0.32, 0.63), (-0.31, 0.31), (0.43, 0.68)
"""Metres: where things stand, and how far from the base, so that a hand that points down reaches them."""
_JAR_GAP, _LID_GAP = 0.14, 0.165
"""Metres between the jars, and between lid and jars: the hand is 20 cm wide and comes down among them."""
_FALLBACK = ((0.50, 0.2), (0.50, 0.0), (0.50, -0.2))


class CloseJar(Task):
    """Twenty variations, one for each colour; beside the jar stands one of another colour.

    The jars are heavy: they slide when pushed, but do not tip over or turn.
    """

    name: ClassVar[str] = "close_jar"
    variations: ClassVar[int] = len(COLOURS)

    def __init__(self) -> None:
        self.threads = tuple(ScrewThread(jar, "lid", _TRAVEL, _ANGLE) for jar in _JARS)
        self.thread = self.threads[0]

    def build(self, spec: mujoco.MjSpec) -> None:
        add_jar_tip(spec)
        for jar, thread in zip(_JARS, self.threads, strict=True):
            thread.add(spec, add_jar(spec, jar), (0, 0, _ENTRY), LID_DEPTH)
        add_lid(spec, _YAW)

    def reset(self, world: World, variation: int) -> None:
        rng = world.rng
        self.variation, self.colour = variation, COLOUR_NAMES[variation]
        self.other_colour = COLOUR_NAMES[(variation + int(rng.integers(1, self.variations))) % self.variations]
        self.description = str(rng.choice(_WORDINGS)).format(self.colour)
        positions = three_placements(rng, _X, _Y, _REACH, (_LID_GAP, _JAR_GAP, _LID_GAP), _FALLBACK)
        for body, position in zip((*_JARS, "lid"), positions, strict=True):
            world.place(body, Pose(np.array((*position, 0.0))))
        for jar, colour in zip(_JARS, (self.colour, self.other_colour), strict=True):
            for part in JAR_PARTS:
                world.paint(f"{jar}_{part}", COLOURS[colour])

    def before_step(self, world: World) -> None:
        for thread in self.threads:
            thread.before_step(world)

    def success(self, world: World) -> bool:
        return self.thread.turned(world) >= _CLOSED and not world.holds("lid")

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        held = world.held_bodies()
        if "lid" not in held:
            wrong = [jar for jar in _JARS if jar in held]
            return [release(world.tool, self._jar_name(jar)) for jar in wrong] + self._fetch(world)
        for thread in self.threads:
            if thread.seated(world):
                return self._turn(world, thread)
        return self._carry(world)

    def _jar_name(self, jar: str) -> str:
        colour = self.colour if jar == _JARS[0] else self.other_colour
        return f"the {colour} jar"

    def _fetch(self, world: World) -> list[Waypoint]:
        """All steps, or those from the grasp on where the hand waits above the lid."""
        wrong = self.threads[1].engaged(world)
        grasp = Pose(world.pose("lid").position, top_down(-_YAW if wrong else _YAW)).shifted(z=_GRASP)
        steps = grasping(world, grasp.shifted(z=_ABOVE), grasp, "top", "the lid", near=0.025)
        grip = Grasp.upright(_GRASP)
        if wrong:
            return [*steps, self._unscrew(world, grip), *self._bring(world, grip)]
        return steps + self._bring(world, grip)[3 * self.thread.seated(world) :]

    def _bring(self, world: World, grip: Grasp) -> list[Waypoint]:
        """The steps from the raise on, for a lid held at a grip."""
        lid, jar, name = world.pose("lid").position, world.pose(_JARS[0]).position, self._jar_name(_JARS[0])
        carry = _CARRY - _GRASP
        raised = grip.hand(np.array((lid[0], lid[1], carry)), _YAW)
        aligned = grip.hand(np.array((jar[0], jar[1], carry)), _YAW)
        placed = grip.hand(np.array((jar[0], jar[1], _ENTRY - _PRESS)), _YAW)
        screwed = grip.hand(np.array((jar[0], jar[1], _ENTRY - _TRAVEL - _PRESS)), -_YAW)
        return [
            Waypoint(raised, False, True, instruct("raise")),
            Waypoint(aligned, False, False, instruct("align", name)),
            Waypoint(placed, False, True, instruct("place", "the lid", name)),
            Waypoint(screwed, False, True, instruct("screw_in", "the lid")),
            release(screwed, "the lid"),
        ]

    def _carry(self, world: World) -> list[Waypoint]:
        """The steps that remain for a lid in the hand and off the threads."""
        steps = self._bring(world, Grasp.of(world.tool, world.pose("lid")))
        beside = np.hypot(*(world.pose("lid").position - world.pose(_JARS[0]).position)[:2])
        turned = abs(hand_yaw(world.tool) - _YAW)
        if beside < 0.012 and turned < 0.2 and world.pose("lid").position[2] > _ENTRY - 0.005:
            # A lid that is down but does not sit is askew in the hand: let go, it falls into place.
            return [release(world.tool, "the lid")] if world.tool.distance(steps[2].pose)[0] < _PUT else steps[2:]
        return steps[1:] if world.tool.position[2] > _CARRY - 0.03 else steps

    def _turn(self, world: World, thread: ScrewThread) -> list[Waypoint]:
        """The steps that remain for a lid in the hand and on a thread."""
        # The thread keeps the lid upright; the hand must not lean against it.
        grip = replace(Grasp.of(world.tool, world.pose("lid")), axis=Grasp.upright(0.0).axis)
        yaw = hand_yaw(world.tool)
        if thread is not self.thread:
            if not thread.engaged(world):
                return self._bring(world, grip)
            if yaw < _YAW - 0.2:
                return [self._unscrew(world, grip), *self._bring(world, grip)]
            return [release(world.tool, "the lid")]
        if thread.turned(world) >= _CLOSED or yaw < 0.2 - _YAW:
            return [release(world.tool, "the lid")]
        return self._bring(world, grip)[3:]

    def _unscrew(self, world: World, grip: Grasp) -> Waypoint:
        jar = world.pose(_JARS[1]).position
        return Waypoint(
            grip.hand(np.array((jar[0], jar[1], _ENTRY)), _YAW), False, True, instruct("screw_out", "the lid")
        )
