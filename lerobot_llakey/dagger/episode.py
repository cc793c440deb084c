"""One episode in which a policy acts and the expert says at each step what it should have done.

DAgger (Ross, Gordon and Bagnell, 2011): a policy that was trained on an expert's states is lost in states of its own
making; labelled by the expert, these become training samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.rollout.actors import Actor
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.recorder import frame_columns, waypoint_action
from lerobot_llakey.sim.tasks.base import Waypoint

Frame = dict[str, Any]
_STILL = 0.02
"""Change of any number of the state (metres, radians, opening) below which an action changed nothing."""


def visited_frames(
    env: LlakeySimEnv, actor: Actor, scene: int, rng: np.random.Generator, expert_share: float
) -> list[Frame]:
    """The keysteps of an episode, as ``ImageDatasetWriter.add_episode`` takes them.

    A step that leaves the arm where it was is followed by one of the expert's, so that an episode does not end in one
    and the same picture.

    Args:
        env: of the task; its episode length bounds the episode.
        actor: who acts.
        scene: index of the scene within the environment's split.
        rng: decides when the expert acts.
        expert_share: share of the actions that it carries out.

    Returns:
        One frame for each state in which the expert knew what to do; none where the scene was solved from the start.
    """
    actor.reset()
    observation, _ = env.reset(seed=scene)
    frames: list[Frame] = []
    previous, stuck, over = "", False, False
    while not over and (waypoint := env.expert_waypoint()):
        frames.append(_labelled(env, observation, waypoint, previous))
        action, said = actor.act(env, observation)
        helped = stuck or rng.random() < expert_share
        if helped:
            action, said = waypoint_action(waypoint), waypoint.instruction
        before = observation["agent_pos"]
        observation, _, terminated, truncated, _ = env.step(np.asarray(action, dtype=np.float32))
        stuck = bool(np.abs(observation["agent_pos"] - before).max() < _STILL)
        # Where not even the expert gets on there is nothing more to learn.
        previous, over = said, terminated or truncated or (helped and stuck)
    return frames


def _labelled(env: LlakeySimEnv, observation: Mapping[str, Any], waypoint: Waypoint, previous: str) -> Frame:
    """An observation with the expert's action and instruction."""
    task, perturbation = env.simulation.task, env.simulation.perturbation
    state, step = observation["agent_pos"], int(observation["step"][0])
    return frame_columns(env.pictures) | {
        schema.TASK: task.description,
        schema.STATE: state,
        schema.VELOCITY: observation["velocity"],
        schema.ACTION: waypoint_action(waypoint, state),
        schema.INSTRUCTION: waypoint.instruction,
        schema.PREVIOUS_INSTRUCTION: previous,
        schema.STEP: observation["step"],
        schema.IS_KEYFRAME: np.array([step > 0]),
        schema.KEYFRAME_INDEX: np.array([step]),
        schema.NEXT_KEYFRAME: np.array([step + 1]),
        schema.EPISODE_SEED: np.array([env.simulation.seed]),
        schema.EPISODE_VARIATION: np.array([int(task.variation)]),
        schema.EPISODE_SEQUENCE: np.array([int(task.sequence)]),
        schema.EPISODE_TASK: task.name,
        schema.EPISODE_EVENT: env.disturbance if perturbation is not None and perturbation.struck else "",
    }
