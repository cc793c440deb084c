"""The recorder: motion first, pictures of chosen frames after."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.perturbations.events import EVENTS
from lerobot_llakey.sim.recorder import Episode, frame_columns, record, render_frames, waypoint_action
from lerobot_llakey.sim.simulation import Simulation

SIZE = 32


@pytest.fixture(scope="module")
def episode(simulation: Simulation) -> Episode:
    """The first episode of the validation seeds whose keyframes match, as nearly all do."""
    seeds = (schema.scene_seed("val", index) for index in range(5))
    return next(found for found in (record(simulation, seed, 1) for seed in seeds) if found.usable)


def test_an_episode_holds_states_keyframes_and_an_instruction_a_segment(episode: Episode) -> None:
    assert episode.success and episode.keyframes_match and episode.usable
    assert episode.states.shape == (len(episode), len(schema.SIM_STATE_NAMES)) and episode.states.dtype == np.float32
    assert len(episode.keyframes) == len(episode.waypoints) == 3
    assert episode.keyframes[-1] == len(episode) - 1
    labels = episode.labels()
    assert labels.instruction[0] == episode.waypoints[0].instruction == "move to the front of the middle handle"
    assert (episode.task, episode.variation) == ("open_drawer", 1)
    assert "middle" in episode.description


def test_the_arm_moves_between_keyframes_and_stands_at_them(episode: Episode) -> None:
    assert (
        episode.velocities.shape == (len(episode), len(schema.SIM_VELOCITY_NAMES))
        and episode.velocities.dtype == np.float32
    )
    fastest = np.abs(episode.velocities[:, :-1]).max(axis=1)
    assert fastest[[0, *episode.keyframes]].max() < 0.1
    for start, end in pairwise([0, *episode.keyframes]):
        moved = np.abs(np.diff(episode.states[start : end + 1, schema.HAND_DIM :], axis=0)).max()
        assert moved < 0.01 or fastest[start:end].max() > 0.1


def test_actions_are_where_the_expert_meant_to_go(episode: Episode) -> None:
    actions = episode.labels().action[[0, *episode.keyframes[:-1]]]
    for action, waypoint, reached in zip(actions, episode.waypoints, episode.states[episode.keyframes], strict=True):
        np.testing.assert_allclose(action[schema.QUATERNION], reached[schema.QUATERNION], atol=1e-6)
        assert np.linalg.norm(action[schema.POSITION] - waypoint.pose.position) < 0.02
        assert abs(action[schema.QUATERNION] @ waypoint.pose.quaternion) > 0.99
        assert action[schema.GRIPPER] == waypoint.gripper_open
        assert action[schema.IGNORE_COLLISION] == waypoint.ignore_collision


def test_what_the_gripper_was_told_counts_and_not_how_far_it_got(episode: Episode) -> None:
    blocked = replace(episode, states=episode.states.copy())
    blocked.states[:, schema.GRIPPER] = 0.5
    told = [waypoint.gripper_open for waypoint in episode.waypoints]
    assert episode.gripper_open == told and len(set(told)) == 2
    actions = blocked.labels().action[[0, *episode.keyframes[:-1]]]
    assert actions[:, schema.GRIPPER].tolist() == told


def test_the_same_seed_gives_the_same_episode(simulation: Simulation, episode: Episode) -> None:
    again = record(simulation, episode.seed, episode.variation)
    np.testing.assert_array_equal(again.states, episode.states)
    np.testing.assert_array_equal(again.qpos, episode.qpos)
    assert again.keyframes == episode.keyframes


def test_pictures_taken_afterwards_are_those_of_the_moment(simulation: Simulation, episode: Episode) -> None:
    world = simulation.world
    record(simulation, episode.seed, episode.variation)
    rig = CameraRig(world.model, SIZE)
    now = rig.render_all(world.data)
    last = len(episode) - 1
    pictures = dict(render_frames(simulation, rig, episode, [0, last]))
    rig.close()
    assert list(pictures) == [0, last]
    for camera in schema.CAMERAS:
        # The arm rests at the end, so the last frame shows the present to within a fraction of a millimetre.
        difference = np.abs(pictures[last][camera].rgb.astype(int) - now[camera].rgb)
        assert (difference > 8).mean() < 0.01
        np.testing.assert_allclose(pictures[last][camera].pose, now[camera].pose, atol=1e-3)
    first, final = pictures[0]["front"], pictures[last]["front"]
    assert (np.abs(first.rgb.astype(int) - final.rgb) > 8).mean() > 0.01


def test_columns_fit_the_contract(simulation: Simulation, episode: Episode) -> None:
    world = simulation.world
    record(simulation, episode.seed, episode.variation)
    rig = CameraRig(world.model, SIZE)
    _, pictures = next(render_frames(simulation, rig, episode, [0]))
    rig.close()
    features = schema.dataset_features(dict.fromkeys(schema.CAMERAS, (SIZE, SIZE)))
    columns = frame_columns(pictures) | episode.labels().row(0) | episode.origin()
    columns |= {schema.STATE: episode.states[0], schema.VELOCITY: episode.velocities[0]}
    assert set(columns) == set(features)
    for key, value in columns.items():
        if not isinstance(value, str):
            assert value.shape == tuple(features[key]["shape"]), key
    depth = columns[schema.depth_key("front")]
    assert depth.dtype == np.uint16 and 500 < depth.min() < 2000


def test_a_world_that_went_on_is_not_rendered(simulation: Simulation, episode: Episode) -> None:
    simulation.reset(episode.seed + 1)
    rig = CameraRig(simulation.world.model, SIZE)
    with pytest.raises(ValueError, match="render before recording the next episode"):
        next(render_frames(simulation, rig, episode, [0]))


def test_labels_need_one_keyframe_a_waypoint(episode: Episode) -> None:
    with pytest.raises(ValueError, match="instruct every segment"):
        replace(episode, keyframes=episode.keyframes[1:]).labels()


@pytest.mark.parametrize("kind", EVENTS)
def test_an_event_is_labelled_as_a_watcher_would(simulation: Simulation, kind: str) -> None:
    seeds = (schema.scene_seed("val", index) for index in range(5))
    episode = next(found for found in (record(simulation, s, 1, disturbance=kind) for s in seeds) if found.usable)
    (cut,) = episode.interruptions
    labels, end = episode.labels(), episode.keyframes[cut.segment]
    interrupted, back = (episode.waypoints[cut.segment + i].instruction for i in range(2))
    assert back == "move to the front of the middle handle"
    seen = min(cut.frame, end)
    assert labels.instruction[seen - 1] == interrupted and labels.previous_instruction[end] == interrupted
    assert labels.instruction[end] == labels.instruction[seen] == back
    meant = waypoint_action(episode.waypoints[cut.segment])
    np.testing.assert_array_equal(labels.action[episode.keyframes[cut.segment - 1]], meant)


def test_an_imprecise_expert_is_labelled_by_what_it_meant(simulation: Simulation) -> None:
    seeds = (schema.scene_seed("val", index) for index in range(9))
    episodes = [record(simulation, seed, 1, disturbance="execution_noise") for seed in seeds]
    cuts = [(episode, cut) for episode in episodes if episode.usable for cut in episode.interruptions]
    assert cuts
    for episode, cut in cuts:
        start = episode.keyframes[cut.segment - 1] if cut.segment else 0
        meant = waypoint_action(episode.waypoints[cut.segment])
        np.testing.assert_array_equal(episode.labels().action[start], meant)
