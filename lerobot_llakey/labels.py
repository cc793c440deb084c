"""The columns that make a recorded trajectory a demonstration: next action, instruction and keyframe of every frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import unit_quaternion
from lerobot_llakey.keyframes.segments import segments

OPEN_ABOVE = 0.9
"""Share of the widest opening above which a gripper counts as open, as RLBench and thereby PerAct and RVT have it: a
gripper that holds something wide is closed."""


@dataclass(frozen=True)
class Interruption:
    """An action that a disturbance kept from reaching its keyframe as meant.

    Attributes:
        segment: which keyframe it was to lead to.
        frame: first frame at which the event can be seen; beyond the keyframe if at none. Only with a segment to follow
            may it lie before the keyframe.
        action: (9,) float32, what the segment was to lead to.
        event: name of the disturbance.
    """

    segment: int
    frame: int
    action: np.ndarray
    event: str = ""


@dataclass(frozen=True)
class Labels:
    """One entry a frame.

    Attributes:
        action: (T, 9) float32, the next keyframe's action; the last frame's is its own.
        instruction: T texts, the instruction that leads to that keyframe.
        previous_instruction: T texts, the instruction last commanded: "" at frame 0, the finished one at a keyframe,
            elsewhere the current one.
        keyframe_index: (T,) int64, the segment that starts at or holds the frame.
        next_frame: (T,) int64, the keyframe that ends this segment.
        is_keyframe: (T,) bool.
        event: T texts, the disturbance that can be seen from a frame on: "" before it or without one.
    """

    action: np.ndarray
    instruction: list[str]
    previous_instruction: list[str]
    keyframe_index: np.ndarray
    next_frame: np.ndarray
    is_keyframe: np.ndarray
    event: list[str]

    def row(self, frame: int) -> dict[str, np.ndarray | str]:
        """The labels of one frame under the contract's names, as ``LeRobotDataset.add_frame`` takes them."""
        return {
            schema.ACTION: self.action[frame],
            schema.INSTRUCTION: self.instruction[frame],
            schema.PREVIOUS_INSTRUCTION: self.previous_instruction[frame],
            schema.STEP: self.keyframe_index[frame : frame + 1].astype(np.float32),
            schema.KEYFRAME_INDEX: self.keyframe_index[frame : frame + 1],
            schema.NEXT_KEYFRAME: self.next_frame[frame : frame + 1],
            schema.IS_KEYFRAME: self.is_keyframe[frame : frame + 1],
            schema.EPISODE_EVENT: self.event[frame],
        }


def label(
    states: np.ndarray,
    keyframes: list[int],
    instructions: Sequence[str],
    ignore_collision: Sequence[bool],
    gripper_open: Sequence[bool],
    interruptions: Sequence[Interruption] = (),
) -> Labels:
    """Label a trajectory.

    The action of a segment is what was *reached* at its keyframe, the tool's pose and the gripper's state, as RVT and
    PerAct take it: so simulated and real recordings are labelled alike.

    Where an event interrupts a segment, the frames before it keep what was meant, and those from it on already lead to
    the next keyframe, with the next instruction: what a watcher would say there, in answer to the interrupted one.

    Args:
        states: (T, 8 or more) a hand, as of the contract, then anything.
        keyframes: increasing frame indices that end at T - 1.
        instructions: what leads to each keyframe.
        ignore_collision: whether the way to each keyframe may touch things.
        gripper_open: what the gripper was commanded to be at each keyframe; see :func:`is_open` where none recorded it.
        interruptions: the segments that a disturbance cut short.

    Raises:
        LlakeyError: if instructions or flags are not one a keyframe, or the keyframes do not fit the states.
    """
    if not len(keyframes) == len(instructions) == len(ignore_collision) == len(gripper_open):
        raise LlakeyError(
            f"Expected an instruction, a collision flag and a gripper's state for each of {len(keyframes)} keyframes, "
            f"got {len(instructions)}, {len(ignore_collision)} and {len(gripper_open)}; instruct every segment."
        )
    parts = segments(keyframes, len(states))
    actions = np.stack(
        [
            keyframe_action(states[frame], opened, ignore)
            for frame, opened, ignore in zip(keyframes, gripper_open, ignore_collision, strict=True)
        ]
    )
    current = [instructions[segment] for segment in parts.index]
    previous = list(current)
    previous[0] = ""
    for keyframe, finished in zip(keyframes, instructions, strict=True):
        previous[keyframe] = finished
    index, next_frame, action = parts.index.copy(), parts.next_frame.copy(), actions[parts.index]
    for cut in interruptions:
        action[parts.index == cut.segment] = cut.action
    event = [""] * len(states)
    for cut in interruptions:
        end = keyframes[cut.segment]
        seen = min(cut.frame, end)
        event[seen:] = [cut.event] * (len(states) - seen)
        if cut.frame < end:
            late = slice(cut.frame, end)
            index[late], next_frame[late], action[late] = cut.segment + 1, keyframes[cut.segment + 1], action[end]
            current[late] = [current[end]] * (end - cut.frame)
    return Labels(action, current, previous, index, next_frame, parts.is_keyframe, event)


def is_open(openings: np.ndarray, widest: float = 1.0) -> np.ndarray:
    """Whether a gripper counts as open, where only its opening was recorded.

    Args:
        openings: any shape.
        widest: the opening that this gripper reaches, such as the largest one of a recording.
    """
    return openings > OPEN_ABOVE * widest


def keyframe_action(hand: np.ndarray, gripper_open: bool, ignore_collision: bool) -> np.ndarray:
    """Action (9,) float32 that leads to a hand (8 or more), its quaternion of the same sign."""
    action = np.empty(schema.ACTION_DIM, dtype=np.float32)
    action[schema.POSITION] = hand[schema.POSITION]
    action[schema.QUATERNION] = unit_quaternion(hand[schema.QUATERNION])
    action[schema.GRIPPER] = gripper_open
    action[schema.IGNORE_COLLISION] = ignore_collision
    return action
