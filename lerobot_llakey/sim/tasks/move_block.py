"""Move a block to a target: one wording, three action sequences (paper, Figure 5a).

The red block is inserted into the purple frame, or slid under the roof of the orange target; the yellow block must be
pulled out of its shelter before it goes to the blue or the green pad. Everything is there in every scene, so what to
do follows from the words and the picture together.
"""

from __future__ import annotations

from typing import ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.sim.objects.blocks import (
    BLOCK,
    PAD,
    ROOF_HEIGHT,
    SHELTER,
    add_bay,
    add_block,
    add_frame,
    add_pad,
    add_shelter,
)
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping, release
from lerobot_llakey.sim.world import World

INSERT, SLIDE, PULL_OUT = range(3)
_VARIATIONS = (
    ("red", "purple", INSERT),
    ("red", "orange", SLIDE),
    ("yellow", "blue", PULL_OUT),
    ("yellow", "green", PULL_OUT),
)
_HIGH, _APPROACH, _PULL, _FRONT = 0.12, 0.09, 0.11, 0.09
_TOP_GRIP = 0.008
"""Metres above a block's centre where a hand from above takes it, so that the fingertips clear the frame."""
_TILT = np.deg2rad(-20)
_BACK_GRIP = np.array([-0.006, 0.0, 0.004])
"""Where a hand leaning back takes a block, relative to its centre: out of the roof's way."""
_DEEPEST_GRIP = 0.004
"""Metres behind a shelter's centre beyond which the hand would meet the roof."""
_ARRIVED, _PUT, _TURNED = 0.03, 0.016, 0.35
"""How far (metres, and radians) a hand may be off and still be above its target or down on it: the next waypoint
corrects the rest."""
_COLUMNS = (-0.23, 0.0, 0.23)
_REACH = {INSERT: 0.015, SLIDE: 0.02, PULL_OUT: PAD}
"""Metres by which a block may miss its target's centre."""
_UNDER_ROOF = 0.012
"""Metres by which a slid block may fall short: one let fall in front of the roof falls short by 0.015 or more."""


class MoveBlock(Task):
    """Four variations, three sequences; the places of everything vary."""

    name: ClassVar[str] = "move_block"
    variations: ClassVar[int] = 4
    sequences: ClassVar[int] = 3

    def build(self, spec: mujoco.MjSpec) -> None:
        for colour in ("red", "yellow"):
            add_block(spec, colour)
        for colour in ("blue", "green"):
            add_pad(spec, colour)
        add_frame(spec, "purple")
        add_bay(spec, "orange")
        add_shelter(spec.worldbody.add_body(name="shelter"))

    def reset(self, world: World, variation: int) -> None:
        self.variation = variation
        self.block, self.target, self.sequence = _VARIATIONS[variation]
        self.description = f"move the {self.block} block to the {self.target} target"
        rng = world.rng
        lane, shelter, rest = rng.permutation(_COLUMNS)
        x, y = rng.uniform(0.53, 0.59), lane + rng.uniform(-0.02, 0.02)
        world.place("orange_target", Pose(np.array((x, y, 0.0))))
        self._place_block(world, "red", (rng.uniform(0.33, 0.40), y + rng.uniform(-0.03, 0.03)), rng.uniform(-0.4, 0.4))
        x, y = rng.uniform(0.53, 0.59), shelter + rng.uniform(-0.03, 0.03)
        world.place("shelter", Pose(np.array((x, y, 0.0))))
        self._place_block(world, "yellow", (x, y), 0.0)
        positions = [(0.34, shelter), (0.36, rest), (0.54, rest)]
        for colour, position in zip(rng.permutation(("purple", "blue", "green")), positions, strict=True):
            yaw = rng.uniform(-0.5, 0.5) if colour == "purple" else 0.0
            centre = np.array((*position, 0.0)) + (rng.uniform(-0.02, 0.02), rng.uniform(-0.03, 0.03), 0.0)
            world.place(f"{colour}_target", Pose(centre, Rotation.from_euler("z", yaw).as_quat()))

    def success(self, world: World) -> bool:
        offset = world.pose(f"{self.target}_target").inverse().apply(world.pose(f"{self.block}_block").position)
        return bool(
            np.abs(offset[:2]).max() < _REACH[self.sequence]
            and (self.sequence != SLIDE or offset[0] > -_UNDER_ROOF)
            and offset[2] < 1.5 * BLOCK
            and not world.holds(f"{self.block}_block")
        )

    def plan(self, world: World) -> list[Waypoint]:
        if self.success(world):
            return []
        return self._drop_other(world) + self._remaining(world)

    def _drop_other(self, world: World) -> list[Waypoint]:
        """Where the wrong block was grasped, it is let go where it is."""
        other = "yellow" if self.block == "red" else "red"
        return [release(world.tool, f"the {other} block")] if world.holds(f"{other}_block") else []

    def _remaining(self, world: World) -> list[Waypoint]:
        held = world.holds(f"{self.block}_block")
        if self.sequence == SLIDE:
            return self._carry_low(world) if held else self._take_from_behind(world, "back") + self._carry_low(world)
        if self.sequence == PULL_OUT and self._inside(world):
            pull = self._pull_out(world)
            return pull if held else self._take_from_behind(world, "front") + pull
        return self._carry(world) if held else self._take_from_above(world) + self._carry(world)

    @property
    def _thing(self) -> str:
        return f"the {self.block} block"

    @property
    def _goal(self) -> str:
        return f"the {self.target} target"

    @staticmethod
    def _place_block(world: World, colour: str, position: tuple[float, float], yaw: float) -> None:
        world.place(f"{colour}_block", Pose(np.array((*position, BLOCK)), Rotation.from_euler("z", yaw).as_quat()))

    def _block_pose(self, world: World) -> tuple[np.ndarray, float]:
        """Centre of the block, and its heading within an eighth of a turn: a cube looks the same every quarter."""
        pose = world.pose(f"{self.block}_block")
        axes = pose.rotation.as_matrix()
        # Of a block that tumbled any axis may be upright; the flattest one gives the heading.
        x, y, _ = axes[:, np.abs(axes[2]).argmin()]
        return pose.position, float((np.arctan2(y, x) + np.pi / 4) % (np.pi / 2) - np.pi / 4)

    def _inside(self, world: World) -> bool:
        """Whether the block stands in its shelter, where no hand can take it from above."""
        offset = world.pose("shelter").inverse().apply(world.pose(f"{self.block}_block").position)
        return bool(-0.05 < offset[0] < SHELTER and abs(offset[1]) < SHELTER and offset[2] < ROOF_HEIGHT)

    def _take(self, world: World, grasp: Pose, before: Pose, side: str) -> list[Waypoint]:
        return grasping(world, before, grasp, side, self._thing)

    def _take_from_above(self, world: World) -> list[Waypoint]:
        position, yaw = self._block_pose(world)
        grasp = Pose(position, top_down(yaw)).shifted(z=_TOP_GRIP)
        return self._take(world, grasp, grasp.shifted(z=_HIGH), "top")

    def _take_from_behind(self, world: World, side: str) -> list[Waypoint]:
        position, yaw = self._block_pose(world)
        bay = world.pose("shelter" if self.sequence == PULL_OUT else "orange_target").position
        if abs(position[1] - bay[1]) < SHELTER and position[0] < bay[0] + SHELTER:
            # A block pushed deeper under the roof is taken by its front edge; one that is turned, which the hand cannot
            # follow under the roof, is straightened by the fingers.
            yaw = 0.0 if position[0] > bay[0] - SHELTER else yaw
            position = np.array((min(position[0], bay[0] + _DEEPEST_GRIP), *position[1:]))
        grasp = Pose(position + Rotation.from_euler("z", yaw).apply(_BACK_GRIP), _leaning_back(yaw))
        return self._take(world, grasp, grasp.advanced(-_APPROACH), side)

    def _carry_low(self, world: World) -> list[Waypoint]:
        goal = Pose(
            world.pose(f"{self.target}_target").position + _BACK_GRIP + (0.0, 0.0, BLOCK + 0.001), _leaning_back(0.0)
        )
        slide = Waypoint(goal, False, True, instruct("slide", self._thing, self._goal))
        forward, sideways, _ = world.tool.position - goal.position
        if forward > -_FRONT and abs(sideways) > 0.03:
            # Beside the target its wall is in the way.
            front = Waypoint(goal.shifted(x=-_FRONT, z=0.003), False, False, instruct("move", "front", self._goal))
            return [front, slide, *self._unless_there(world, slide)[-1:]]
        return self._unless_there(world, slide)

    def _pull_out(self, world: World) -> list[Waypoint]:
        goal = world.pose("shelter").shifted(x=-_PULL).position + _BACK_GRIP + (0.0, 0.0, BLOCK + 0.001)
        pull = Waypoint(Pose(goal, _leaning_back(0.0)), False, True, instruct("pull_out", self._thing))
        return [pull, _raised(pull.pose), *self._put(world, pull.pose)]

    def _carry(self, world: World) -> list[Waypoint]:
        """Up, over the target, down onto it, let go."""
        tool = world.tool
        above = self._above(world, tool)
        sideways = np.linalg.norm(tool.position[:2] - above.position[:2])
        if sideways > _ARRIVED and tool.position[2] < 0.6 * _HIGH:
            return [_raised(tool), *self._put(world, tool)]
        arrived = sideways < _ARRIVED and tool.distance(above)[1] < _TURNED
        return self._put(world, tool)[bool(arrived) :]

    def _put(self, world: World, tool: Pose) -> list[Waypoint]:
        """Over the target, down onto it, let go, with a block held as at a pose of the tool."""
        above = self._above(world, tool)
        down = Pose(above.position * (1, 1, 0) + (0, 0, self._low(tool)), above.quaternion)
        if self.sequence == INSERT:
            arrive, put = instruct("align", self._goal), instruct("insert", self._thing, self._goal)
        else:
            arrive, put = instruct("move", "top", self._goal), instruct("place", self._thing, self._goal)
        lower = self._unless_there(world, Waypoint(down, False, True, put))
        return [Waypoint(above, False, False, arrive), *lower]

    def _above(self, world: World, tool: Pose) -> Pose:
        """Where the tool belongs above the target, held as it is: from above, or leaning back."""
        target = world.pose(f"{self.target}_target")
        if self._leans(tool):
            return Pose(target.position + _BACK_GRIP * (1, 1, 0) + (0, 0, _HIGH + BLOCK), _leaning_back(0.0))
        yaw = float(target.rotation.as_euler("zyx")[0])
        return Pose(target.position + (0, 0, _HIGH + BLOCK), top_down(yaw))

    def _low(self, tool: Pose) -> float:
        """Height of the tool when the block in it stands on the target, a few millimetres to spare."""
        floor = 0.004 if self.sequence == INSERT else 0.007
        return floor + BLOCK + (_BACK_GRIP[2] if self._leans(tool) else _TOP_GRIP)

    @staticmethod
    def _leans(tool: Pose) -> bool:
        return bool(tool.rotation.as_matrix()[2, 2] > -np.cos(_TILT / 2))

    def _unless_there(self, world: World, waypoint: Waypoint) -> list[Waypoint]:
        """The waypoint and the release after it, or the release alone where the tool has arrived."""
        let_go = release(waypoint.pose, self._thing)
        distance, angle = world.tool.distance(waypoint.pose)
        return [let_go] if distance < _PUT and angle < _TURNED else [waypoint, let_go]


def _raised(tool: Pose) -> Waypoint:
    return Waypoint(tool.shifted(z=_HIGH), False, True, instruct("raise"))


def _leaning_back(yaw: float) -> np.ndarray:
    """Quaternion of a hand above and behind what it takes, heading along ``yaw``."""
    hand = Rotation.from_euler("y", _TILT) * Rotation.from_quat((1.0, 0.0, 0.0, 0.0))
    return (Rotation.from_euler("z", yaw) * hand).as_quat()
