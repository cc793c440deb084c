"""Labels: every frame's next action, instruction and keyframe."""

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.labels import Interruption, is_open, keyframe_action, label

INSTRUCTIONS = ["move to the top of the cup", "grasp the cup"]


def states(openings: list[float]) -> np.ndarray:
    """A robot that rises a centimetre a frame."""
    trajectory = np.zeros((len(openings), len(schema.SIM_STATE_NAMES)), dtype=np.float32)
    trajectory[:, 2] = 0.01 * np.arange(len(openings))
    trajectory[:, schema.QUATERNION] = (1, 0, 0, 0)
    trajectory[:, schema.GRIPPER] = openings
    return trajectory


def test_every_frame_gets_the_pose_reached_at_the_next_keyframe_and_its_instruction() -> None:
    labels = label(states([1, 1, 1, 1, 0.6, 0.6]), [2, 5], INSTRUCTIONS, [False, True], [True, False])
    np.testing.assert_allclose(labels.action[:, 2], [0.02, 0.02, 0.05, 0.05, 0.05, 0.05])
    np.testing.assert_array_equal(labels.action[:, schema.GRIPPER], [1, 1, 0, 0, 0, 0])
    np.testing.assert_array_equal(labels.action[:, schema.IGNORE_COLLISION], [0, 0, 1, 1, 1, 1])
    assert labels.instruction == [INSTRUCTIONS[0]] * 2 + [INSTRUCTIONS[1]] * 4
    np.testing.assert_array_equal(labels.next_frame, [2, 2, 5, 5, 5, 5])
    np.testing.assert_array_equal(labels.keyframe_index, [0, 0, 1, 1, 1, 1])
    np.testing.assert_array_equal(labels.is_keyframe, [0, 0, 1, 0, 0, 1])


def test_the_previous_instruction_is_none_at_first_the_finished_one_at_keyframes_and_else_the_current_one() -> None:
    labels = label(states([1] * 6), [2, 5], INSTRUCTIONS, [False, True], [True, False])
    first, second = INSTRUCTIONS
    assert labels.previous_instruction == ["", first, first, second, second, second]


def test_a_row_holds_the_contracts_label_columns() -> None:
    row = label(states([1] * 3), [2], INSTRUCTIONS[:1], [False], [True]).row(1)
    features = schema.dataset_features()
    for key, value in row.items():
        if isinstance(value, str):
            assert features[key]["dtype"] == "string"
        else:
            assert (value.dtype.name, value.shape) == (features[key]["dtype"], features[key]["shape"])
    assert [
        label(states([1] * 6), [2, 5], INSTRUCTIONS, [False, True], [True, False]).row(i)[schema.STEP] for i in (1, 2)
    ] == [0, 1]
    assert set(row) >= {schema.ACTION, schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION, schema.NEXT_KEYFRAME}


def test_an_action_is_what_was_commanded_and_keeps_the_sign_of_the_state() -> None:
    state = states([0.95])[0]
    state[schema.QUATERNION] = (0.6, 0, 0, -0.8)
    action = keyframe_action(state, gripper_open=False, ignore_collision=True)
    assert action[schema.GRIPPER] == 0 and action[schema.IGNORE_COLLISION] == 1
    np.testing.assert_allclose(action[schema.QUATERNION], (0.6, 0, 0, -0.8), atol=1e-6)


def test_where_no_command_is_known_a_gripper_is_open_near_the_widest_it_reaches() -> None:
    assert is_open(np.array([0.0, 0.85, 0.95])).tolist() == [False, False, True]
    assert is_open(np.array([0.0, 0.5, 0.58]), widest=0.6).tolist() == [False, False, True]


def test_a_segment_without_instruction_is_refused() -> None:
    with pytest.raises(ValueError, match=r"2 keyframes, got 1, 2 and 2"):
        label(states([1] * 6), [2, 5], INSTRUCTIONS[:1], [False, True], [True, True])


def test_frames_after_an_event_lead_to_the_next_keyframe_and_those_before_keep_what_was_meant() -> None:
    meant = np.array([0.5, 0, 0, 1, 0, 0, 0, 0, 1], dtype=np.float32)
    labels = label(
        states([1] * 8), [4, 7], INSTRUCTIONS, [False, True], [True, True], [Interruption(0, 2, meant, "drop")]
    )
    first, second = INSTRUCTIONS
    np.testing.assert_array_equal(labels.action[:2], [meant, meant])
    np.testing.assert_allclose(labels.action[2:, 2], 0.07)
    assert labels.instruction == [first] * 2 + [second] * 6
    # Asked right after the event, a watcher answers to the instruction that was cut short.
    assert labels.previous_instruction == ["", *[first] * 4, *[second] * 3]
    np.testing.assert_array_equal(labels.next_frame, [4, 4, 7, 7, 7, 7, 7, 7])
    np.testing.assert_array_equal(labels.is_keyframe, [0, 0, 0, 0, 1, 0, 0, 1])
    assert labels.event == [""] * 2 + ["drop"] * 6


def test_a_keyframe_off_its_mark_is_labelled_by_what_was_meant() -> None:
    meant = np.array([0.5, 0, 0, 1, 0, 0, 0, 0, 1], dtype=np.float32)
    labels = label(
        states([1] * 6),
        [2, 5],
        INSTRUCTIONS,
        [False, True],
        [True, True],
        [Interruption(1, 99, meant, "execution_noise")],
    )
    np.testing.assert_allclose(labels.action[:2, 2], 0.02)
    np.testing.assert_array_equal(labels.action[2:], [meant] * 4)
    assert labels.event == [""] * 5 + ["execution_noise"]
    assert labels.instruction == [INSTRUCTIONS[0]] * 2 + [INSTRUCTIONS[1]] * 4
