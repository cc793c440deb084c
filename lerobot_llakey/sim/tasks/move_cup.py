"""Move the upward or the upside-down cup to a target: one wording, four action sequences (paper, Figure 5c).

An upward cup in the open is clamped by its rim and carried; under the ledge its rim is out of reach, and it is gripped
by its sides and slid. An upside-down cup is turned over on the way, and pulled out first where it stands in the
cabinet. Both cups, the ledge and the cabinet are there in every scene.
"""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.objects.cup import CUP_HEIGHT, CUP_RADIUS, CUP_WALL, add_cup
from lerobot_llakey.sim.objects.shelters import SHELTER_HALF_WIDTH, add_cabinet, add_ledge
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

CLAMP, SLIDE, TURN, PULL_OUT = range(4)
_POSES = ("upward", "upside-down")
_LOOKS = ((0.93, 0.91, 0.85), (0.90, 0.45, 0.55))
_TARGETS = {"blue": (0.10, 0.25, 0.90), "green": (0.10, 0.65, 0.20), "yellow": (0.95, 0.85, 0.10)}
_PAD = 0.05
_LANES, _PADS = (0.365, 0.52, 0.675), (0.36, 0.49, 0.62)
"""Metres in front of the robot: shelters and the cup in the open, and the targets."""
_FRONT, _OPEN_Y, _PAD_Y = (0.25, 0.28), (0.04, 0.09), (-0.10, -0.05)
"""Metres to the robot's left: the shelters' front edges, the cup in the open, and the targets."""
_INSIDE, _REACH = 0.018, 0.03
"""Metres from a shelter's front edge to the axis of the cup in it, and by which a cup may miss its target's centre."""
_LEFTWARDS = Rotation.from_matrix(np.array(((0, -1, 0), (0, 0, 1), (-1, 0, 0)), dtype=float))
"""A level hand that points to the robot's left, its x axis down: from there joint 7 can turn it by 180 degrees."""
_GRIP, _RIM_GRIP = 0.07, 0.013
"""Height of a level hand that grips a cup by its sides, and how far below the rim a hand from above clamps it."""
_BEHIND, _HIGHER, _ABOVE = 0.08, 0.03, 0.10
_HIGH, _CARRY, _PULL = 0.23, 0.12, 0.125
"""Height of the hand that turns a cup over, of the bottom of a cup on the way, and metres to pull out of a shelter."""
_SHORT, _PLAY = 0.003, 0.013
"""Metres by which a level hand stops short of a cup's axis, and may be beside the cabinet's middle to pass it."""
_ROOM = np.array(((0.34, -0.12, 0.0), (0.68, 0.30, 1.0)))
"""Metres: where a level hand can turn about."""
_ASIDE, _ASIDE_FROM = 0.03, 0.14
"""Metres from its middle at which a cup is taken that lies this far to the left, by the shelters."""
_HOVER, _DROP, _WRIST = 0.008, 0.016, 0.052
"""Metres by which a pulled or slid cup is held too high, so as not to press on the table, above the target at which a
cup is let go, and below which the wrist of a level hand meets the table."""
_LEAD, _LEAN = np.deg2rad((25, 10))
"""Radians by which a hand that raises an upside-down cup begins to turn it, so that there is one shortest way to go on,
and by which a cup may lean when it is let go: it comes to stand."""
_ARRIVED, _PUT, _LOW, _TURNED = 0.03, 0.023, 0.02, 0.35
"""How far (metres, and radians) a hand or a cup may be off and still be there: the next waypoint corrects the rest."""


class MoveCup(Task):
    """Twelve variations: four sequences, three targets each."""

    name: ClassVar[str] = "move_cup"
    variations: ClassVar[int] = 12
    sequences: ClassVar[int] = 4

    def build(self, spec: mujoco.MjSpec) -> None:
        for pose, look in zip(_POSES, _LOOKS, strict=True):
            add_cup(spec, f"{pose}_cup", look)
        add_cabinet(spec, "cabinet")
        add_ledge(spec, "ledge")
        for colour, rgb in _TARGETS.items():
            # Flush with the table: a cup slides onto it without a step.
            spec.worldbody.add_body(name=f"{colour}_target").add_geom(
                type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=(_PAD, 0.001, 0), rgba=(*rgb, 1), contype=0, conaffinity=0
            )

    def reset(self, world: World, variation: int) -> None:
        self.variation = variation
        self.sequence, colour = divmod(variation, len(_TARGETS))
        self.target = tuple(_TARGETS)[colour]
        self.pose = _POSES[self.sequence in (TURN, PULL_OUT)]
        self.description = f"move the {self.pose} cup to the {self.target} target"
        rng = world.rng
        places = {}
        for name, lane in zip(("cabinet", "ledge", "open"), rng.permutation(_LANES), strict=True):
            x = lane + rng.uniform(-0.002, 0.002)
            if name == "open":
                places[name] = np.array((x, rng.uniform(*_OPEN_Y), 0.0))
                continue
            front = np.array((x, rng.uniform(*_FRONT), 0.0))
            world.place(name, Pose(front))
            places[name] = front + (rng.uniform(-0.005, 0.005), _INSIDE + rng.uniform(-0.004, 0.003), 0.0)
        for name, x in zip(_TARGETS, rng.permutation(_PADS), strict=True):
            world.place(f"{name}_target", Pose(np.array((x + rng.uniform(-0.012, 0.012), rng.uniform(*_PAD_Y), 0.0))))
        # A cup in the open next to the cabinet's lane would be in the hand's way.
        far = abs(places["open"][0] - places["cabinet"][0]) > 0.2
        in_the_open = self.sequence == CLAMP or (self.sequence == PULL_OUT and far)
        yaw = [Rotation.from_euler("z", angle) for angle in rng.uniform(-np.pi, np.pi, 2)]
        world.place("upward_cup", Pose(places["open" if in_the_open else "ledge"], yaw[0].as_quat()))
        position = places["open" if self.sequence == TURN else "cabinet"] + (0, 0, CUP_HEIGHT)
        world.place("upside-down_cup", Pose(position, (yaw[1] * Rotation.from_euler("x", np.pi)).as_quat()))

    def success(self, world: World) -> bool:
        cup = self._cup(world)
        return bool(
            _opening(cup)[2] > 0.95
            and self._off(world, cup) < _REACH
            and cup.position[2] < 0.012
            and not world.holds(f"{self.pose}_cup")
        )

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        held = world.held_bodies()
        for pose in _POSES:
            if pose != self.pose and f"{pose}_cup" in held:
                return [release(world.tool, f"the {pose} cup"), *self._take(world)]
        return self._bring(world, world.tool, self._cup(world)) if f"{self.pose}_cup" in held else self._take(world)

    @property
    def _thing(self) -> str:
        return f"the {self.pose} cup"

    @property
    def _goal(self) -> str:
        return f"the {self.target} target"

    def _cup(self, world: World) -> Pose:
        return world.pose(f"{self.pose}_cup")

    def _off(self, world: World, cup: Pose) -> float:
        """Metres between the cup's bottom and its target, seen from above."""
        return float(np.linalg.norm((cup.position - world.pose(f"{self.target}_target").position)[:2]))

    def _shelter(self, world: World, cup: Pose, room: float) -> Pose | None:
        """The shelter in or before which the cup is, nearer than ``room`` metres to its front edge."""
        middle = cup.apply((0.0, 0.0, CUP_HEIGHT / 2))
        for name in ("cabinet", "ledge"):
            x, y, _ = middle - world.pose(name).position
            if abs(x) < SHELTER_HALF_WIDTH + room / 2 and y > -room:
                return world.pose(name)
        return None

    def _take(self, world: World) -> list[Waypoint]:
        """To the cup, grasp it, and all that follows."""
        cup = self._cup(world)
        up, middle = _opening(cup), cup.apply((0.0, 0.0, CUP_HEIGHT / 2))
        if abs(up[2]) < 0.7:
            if middle[1] > _ASIDE_FROM:
                # By the end that is farther from the shelters, out of their way.
                middle = middle - np.sign(up[1]) * _ASIDE * up
            grasp = Pose(middle, top_down(np.arctan2(up[1], up[0])))
            before, side = grasp.shifted(z=_ABOVE), "top"
        elif up[2] > 0.93 and self._shelter(world, cup, 0.09) is None:
            rim = cup.position + (0.0, CUP_WALL / 2 - CUP_RADIUS, CUP_HEIGHT - _RIM_GRIP)
            grasp = Pose(rim, top_down())
            before, side = grasp.shifted(z=_ABOVE), "top"
        else:
            (x, y, _), cabinet = middle, world.pose("cabinet").position
            if abs(x - cabinet[0]) < SHELTER_HALF_WIDTH and y > cabinet[1]:
                x = np.clip(x, cabinet[0] - _PLAY, cabinet[0] + _PLAY)
            grasp = Pose(np.array((x, y - _SHORT, _GRIP)), _LEFTWARDS.as_quat())
            before, side = grasp.shifted(y=-_BEHIND, z=_HIGHER), "right side"
        return grasping(world, before, grasp, side, self._thing) + self._bring(world, grasp, cup)

    def _bring(self, world: World, tool: Pose, cup: Pose) -> list[Waypoint]:
        """What remains for a cup that the tool holds: out, up, upright, over the target, down, let go."""
        grip = tool.inverse() @ cup
        along = grip.rotation.as_matrix()[2, 2]
        if along > 0.6:
            # Held by its bottom: no hand can turn it over.
            return [release(tool, self._thing)]
        upright = _upright(grip)
        goal = world.pose(f"{self.target}_target").position

        def at(height: float) -> Pose:
            """The tool's pose that holds the cup upright over the target."""
            x, y, z = goal + (0, 0, height) - upright.apply(grip.position)
            return Pose(np.array((x, y, max(z, _WRIST))), upright.as_quat())

        top = Waypoint(at(_CARRY), False, False, instruct("move", "top", self._goal))
        place = Waypoint(at(_DROP), False, True, instruct("place", self._thing, self._goal))
        let_go = release(place.pose, self._thing)
        turned, low = _opening(cup)[2] > np.cos(_TURNED), cup.apply((0, 0, CUP_HEIGHT / 2))[2] < 0.12
        if turned:
            if self._off(world, cup) < _PUT and tool.position[2] < place.pose.position[2] + _LOW:
                return [let_go]
            if self._off(world, cup) < _ARRIVED:
                return [place, let_go]
            if low and along > -0.7:
                slid = Waypoint(at(_HOVER), False, True, instruct("slide", self._thing, self._goal))
                return [slid, release(slid.pose, self._thing)]
            return [_raise(tool, upright), top, place, let_go] if low else [top, place, let_go]
        steps = []
        shelter = self._shelter(world, cup, 0.05)
        if shelter is not None and low:
            out = np.array((shelter.position[0], shelter.position[1] - _PULL, _GRIP + _HOVER))
            tool = Pose(out, _LEFTWARDS.as_quat())
            steps.append(Waypoint(tool, False, True, instruct("pull_out", self._thing)))
        turning = tool.rotation
        if _opening(cup)[2] < -0.9:
            side = 1.0 if tool.rotation.as_matrix()[2, 0] > 0 else -1.0
            turning = upright * Rotation.from_euler("z", -side * (np.pi - _LEAD))
        raised = _raise(tool, turning)
        if low:
            steps.append(raised)
        there = Pose(np.clip(raised.pose.position, *_ROOM), upright.as_quat())
        rotated = Waypoint(there, False, False, instruct("rotate", self._thing, "the upright pose"))
        return [*steps, rotated, top, place, let_go]


def _opening(cup: Pose) -> np.ndarray:
    """(3,) unit vector out of a cup's opening."""
    return cup.rotation.as_matrix()[:, 2]


def _raise(tool: Pose, rotation: Rotation) -> Waypoint:
    high = Pose(tool.position * (1, 1, 0) + (0, 0, _HIGH), rotation.as_quat())
    return Waypoint(high, False, True, instruct("raise"))


def _upright(grip: Pose) -> Rotation:
    """The hand's rotation that holds a cup, at ``grip`` in its frame, upright.

    A hand that reaches down to it keeps its fingers along y; any other points to the robot's left.
    """
    axis = grip.rotation.as_matrix()[:, 2]
    ahead, goal = (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    if axis[2] > -0.7:
        ahead, goal = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
        # A level hand that would have to point upwards leaves the cup leaning instead: its wrist would meet the table.
        axis = axis - (0.0, 0.0, np.clip(axis[2], 0.0, np.sin(_LEAN)))
        axis /= np.linalg.norm(axis)
    forward = np.subtract(ahead, np.dot(ahead, axis) * axis)
    forward /= np.linalg.norm(forward)
    hand = np.column_stack((forward, np.cross(axis, forward), axis))
    world = np.column_stack((goal, np.cross((0.0, 0.0, 1.0), goal), (0.0, 0.0, 1.0)))
    return Rotation.from_matrix(world @ hand.T)
