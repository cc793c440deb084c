import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey import schema
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Said, choose
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor, about_tool_axis, set_gripper, straight_up


def _supervisor(seed: int = 0, workspace=schema.WORKSPACE, **settings) -> Supervisor:
    action = LlakeyActionConfig(device="cpu", workspace=[list(bounds) for bounds in workspace])
    return Supervisor(LlakeyConfig(action=action, device="cpu", **settings), np.random.default_rng(seed))


def _accept(supervisor: Supervisor, text: str, source: str = "policy") -> str:
    config = supervisor.config
    supervisor.accept(choice := choose(Said(text, source), supervisor.last, config.spoken, config.fallback))
    return choice.instruction


def _action(gripper: float = 1.0) -> np.ndarray:
    return np.array([0.4, 0.1, 0.3, 2.0, 0.0, 0.0, 0.0, gripper, 1.0], dtype=np.float32)


def _state(opening: float = 1.0) -> np.ndarray:
    return np.array([0.5, -0.1, 0.4, 0.0, 1.0, 0.0, 0.0, opening, *[0.0] * 7], dtype=np.float32)


def test_counts_repeats_whatever_the_wording_and_starts_anew_with_another_instruction() -> None:
    supervisor = _supervisor()
    seen = []
    for text in ("grasp the lid", "grab the lid", "Grasp the lid.", "raise the robotic arm", "grasp the lid"):
        _accept(supervisor, text)
        seen.append(supervisor.repeats)
    assert seen == [0, 1, 2, 0, 0]
    assert supervisor.last.instruction == "grasp the lid"


def test_keeps_the_last_valid_instruction_and_counts_the_rest() -> None:
    supervisor = _supervisor()
    assert _accept(supervisor, "gibberish") == "raise the robotic arm"
    assert _accept(supervisor, "grasp the lid") == "grasp the lid"
    assert _accept(supervisor, "grasp") == "grasp the lid"
    assert _accept(supervisor, "") == "grasp the lid"
    assert (supervisor.unparsable, supervisor.repeats) == (3, 2)


@pytest.mark.parametrize(
    ("text", "given", "expected"),
    [
        ("grasp the lid", 1.0, 0.0),
        ("move to the top of the jar and release the lid", 0.0, 1.0),
        ("raise the robotic arm", 0.0, 0.0),
        ("raise the robotic arm", 1.0, 1.0),
    ],
)
def test_the_words_decide_on_the_gripper_where_they_say_so(text: str, given: float, expected: float) -> None:
    supervisor = _supervisor()
    _accept(supervisor, text)
    adjusted = supervisor.adjust(_action(given), _state())
    assert adjusted[schema.GRIPPER] == expected
    assert np.allclose(adjusted[[0, 1, 2, 8]], _action()[[0, 1, 2, 8]])


def test_quaternions_come_out_at_unit_length_and_zeros_are_refused() -> None:
    supervisor = _supervisor()
    _accept(supervisor, "raise the robotic arm")
    assert np.allclose(supervisor.adjust(_action(), _state())[schema.QUATERNION], [1, 0, 0, 0])
    with pytest.raises(ValueError, match="non-zero length"):
        supervisor.adjust(np.zeros(9), _state())


def test_random_moves_begin_past_the_threshold_and_start_the_count_anew() -> None:
    supervisor = _supervisor(repeat_threshold=2, random_move_probability=1.0)
    moved = []
    for _ in range(9):
        _accept(supervisor, "slide the block to the mark")
        supervisor.adjust(_action(), _state())
        moved.append(supervisor.random_moves)
    assert moved == [0, 0, 0, 1, 1, 1, 2, 2, 2]


def test_random_moves_stay_near_the_gripper_and_keep_hand_and_grasp() -> None:
    supervisor = _supervisor(repeat_threshold=0, random_move_probability=1.0, random_move_radius=0.1)
    distances = []
    _accept(supervisor, "grasp the lid")
    supervisor.adjust(_action(), _state(opening=0.6))
    for _ in range(200):
        _accept(supervisor, "pull the lid out")
        supervisor.repeats = 1
        adjusted = supervisor.adjust(_action(gripper=1.0), _state(opening=0.6))
        distances.append(float(np.linalg.norm(adjusted[:3] - _state()[:3])))
        assert np.allclose(adjusted[schema.QUATERNION], _state()[schema.QUATERNION])
        assert (adjusted[schema.GRIPPER], adjusted[schema.IGNORE_COLLISION]) == (0.0, 0.0)
    assert max(distances) <= 0.1 + 1e-6
    assert np.mean(distances) == pytest.approx(0.075, abs=0.006)  # three quarters of the radius in a uniform ball


def test_random_moves_come_with_their_probability_and_stay_in_the_workspace() -> None:
    supervisor = _supervisor(
        repeat_threshold=0,
        random_move_probability=0.3,
        random_move_radius=0.5,
        workspace=((0, 0.55), (-0.2, 0), (0, 0.45)),
    )
    _accept(supervisor, "grasp the lid")
    for _ in range(1000):
        supervisor.repeats = 1
        adjusted = supervisor.adjust(_action(), _state())
        if supervisor.repeats == 0:
            assert np.all(adjusted[:3] <= np.float32([0.55, 0, 0.45])) and np.all(
                adjusted[:3] >= np.float32([0, -0.2, 0])
            )
    assert 250 < supervisor.random_moves < 350


def test_same_seed_same_moves() -> None:
    runs = []
    for seed in (1, 1, 2):
        supervisor = _supervisor(seed, repeat_threshold=0, random_move_probability=1.0)
        supervisor.repeats = 1
        runs.append(supervisor.adjust(_action(), _state()))
    assert np.array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_free_text_goes_through_uncounted() -> None:
    supervisor = _supervisor(commander="task", repeat_threshold=0, random_move_probability=1.0)
    for _ in range(5):
        assert _accept(supervisor, "open the top drawer") == "open the top drawer"
        assert np.allclose(supervisor.adjust(_action(), _state())[:3], _action()[:3])
    assert (supervisor.repeats, supervisor.unparsable, supervisor.random_moves) == (0, 0, 0)


def test_a_command_repeated_for_ever_leads_to_random_moves_now_and_then() -> None:
    """The stall rule as stated: nothing up to the threshold, then a chance at each step, and the count anew."""
    supervisor = _supervisor(repeat_threshold=3, random_move_probability=0.5, random_move_radius=0.1)
    state, since, waits = _state(), 0, []
    for _ in range(400):
        supervisor.observe(state)
        _accept(supervisor, "slide the block to the mark")
        before = supervisor.random_moves
        sent = supervisor.adjust(_action(), state)
        if supervisor.random_moves > before:
            assert np.linalg.norm(sent[:3] - state[:3]) <= 0.1 + 1e-6
            assert supervisor.repeats == 0
            waits.append(since)
            since = 0
        else:
            assert np.allclose(sent[:3], _action()[:3])
            since += 1
        state[:3] = sent[:3]
    assert min(waits[1:]) == 3 and waits[0] >= 4
    assert 4.5 > np.mean(waits) > 3.5  # three in any case, and one more on average before a chance of one half comes up


def test_a_hand_at_the_edge_or_outside_stays_within_the_radius_and_goes_no_further_out() -> None:
    workspace = ((0.0, 0.5), (-0.1, 0.1), (0.0, 0.4))
    supervisor = _supervisor(
        random_move_radius=0.1, repeat_threshold=0, random_move_probability=1.0, workspace=workspace
    )
    low, high = np.array(workspace).T
    for hand in ([0.5, 0.0, 0.2], [0.7, 0.0, 0.2], [-0.3, -0.4, 0.6], [0.25, 0.0, 0.2]):
        state = _state()
        state[:3] = hand
        for _ in range(100):
            _accept(supervisor, "pull the lid out")
            supervisor.repeats = 1
            place = supervisor.adjust(_action(), state)[:3].astype(np.float64)
            assert np.linalg.norm(place - state[:3]) <= 0.1 + 1e-6
            assert np.all(place >= np.minimum(low, state[:3]) - 1e-6)
            assert np.all(place <= np.maximum(high, state[:3]) + 1e-6)


def test_sees_whether_a_step_moved_hand_or_gripper() -> None:
    supervisor = _supervisor()
    seen = []
    for x, turn, opening in (
        (0.5, 0.0, 1.0),
        (0.504, 0.0, 1.0),
        (0.51, 0.0, 1.0),
        (0.51, 0.03, 1.0),
        (0.51, 0.1, 1.0),
        (0.51, 0.1, 0.95),
        (0.51, 0.1, 0.5),
    ):
        state = _state(opening)
        state[0], state[3:7] = x, (0.0, np.cos(turn / 2), np.sin(turn / 2), 0.0)
        supervisor.observe(state)
        seen.append(supervisor.moved)
    assert seen == [None, False, True, False, True, False, True]
    assert all(type(moved) in (bool, type(None)) for moved in seen)


def test_a_persons_words_are_not_repetitions() -> None:
    supervisor = _supervisor(repeat_threshold=0, random_move_probability=1.0)
    for _ in range(5):
        _accept(supervisor, "grasp the lid", "person")
        supervisor.adjust(_action(), _state())
    assert (supervisor.repeats, supervisor.random_moves) == (0, 0)
    _accept(supervisor, "grasp the lid")
    assert supervisor.repeats == 1


@pytest.mark.parametrize(
    ("text", "setting"), [("screw the lid in", "screw_about_tool_axis"), ("raise the robotic arm", "raise_upward")]
)
def test_screwing_and_raising_are_held_to_their_words_where_that_is_set(text: str, setting: str) -> None:
    state = _state()  # points straight down at z = 0.4
    low = np.array([0.6, 0.1, 0.3, 1.0, 1.0, 0.0, 0.2, 0.0, 0.0])
    for on in (False, True):
        supervisor = _supervisor(**{setting: on})
        _accept(supervisor, text)
        sent = supervisor.adjust(low, state)
        assert np.allclose(sent[:2], state[:2] if on else low[:2])
        if setting == "raise_upward":
            assert sent[2] == pytest.approx(0.4 if on else 0.3)
            continue
        x, y = sent[schema.QUATERNION][:2]
        assert (abs(1 - 2 * (x * x + y * y) + 1) < 1e-6) == on  # the tool axis points straight down
    other = _supervisor(screw_about_tool_axis=True, raise_upward=True)
    _accept(other, "place the lid on the jar")
    assert np.allclose(other.adjust(low, state)[:3], low[:3])


def _pose(rng: np.random.Generator, length: int) -> np.ndarray:
    values = np.zeros(length)
    values[schema.POSITION] = rng.uniform(-0.5, 0.5, 3)
    values[schema.QUATERNION] = Rotation.random(random_state=int(rng.integers(2**31))).as_quat()
    values[schema.GRIPPER] = 1.0
    return values


def test_a_screw_turns_about_and_goes_along_the_tool_axis_only() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        state, action = _pose(rng, 15), _pose(rng, 9)
        changed = about_tool_axis(action, state)
        present, after = (Rotation.from_quat(pose[schema.QUATERNION]) for pose in (state, changed))
        axis = present.as_matrix()[:, 2]
        assert np.allclose(after.as_matrix()[:, 2], axis)
        moved = changed[schema.POSITION] - state[schema.POSITION]
        assert np.allclose(np.cross(moved, axis), 0)
        assert axis @ moved == pytest.approx(axis @ (action[schema.POSITION] - state[schema.POSITION]))


def test_a_screw_that_is_one_already_stays_as_it_is() -> None:
    rng = np.random.default_rng(1)
    for degrees in (-120, 5, 110, 180):
        state, action = _pose(rng, 15), np.zeros(9)
        present = Rotation.from_quat(state[schema.QUATERNION])
        action[schema.POSITION] = state[schema.POSITION] + 0.01 * present.as_matrix()[:, 2]
        action[schema.QUATERNION] = (present * Rotation.from_euler("z", degrees, degrees=True)).as_quat()
        changed = about_tool_axis(action, state)
        assert np.allclose(changed[schema.POSITION], action[schema.POSITION])
        assert abs(changed[schema.QUATERNION] @ action[schema.QUATERNION]) == pytest.approx(1.0)


def test_half_a_turn_about_another_axis_has_no_screw_in_it() -> None:
    state, action = np.zeros(15), np.zeros(9)
    state[schema.QUATERNION] = 0, 0, 0, 1
    action[schema.QUATERNION] = 1, 0, 0, 0
    assert np.allclose(about_tool_axis(action, state)[schema.QUATERNION], state[schema.QUATERNION])


@pytest.mark.parametrize(("height", "expected"), [(0.5, 0.5), (0.1, 0.3)])
def test_raising_goes_straight_up(height: float, expected: float) -> None:
    state, action = np.zeros(15), np.zeros(9)
    state[schema.POSITION] = 0.4, -0.1, 0.3
    action[:7] = 0.6, 0.2, height, 0, 0, 1, 0
    changed = straight_up(action, state)
    assert np.allclose(changed[schema.POSITION], [0.4, -0.1, expected])
    assert np.array_equal(changed[schema.QUATERNION], action[schema.QUATERNION])


def test_grasping_closes_and_releasing_opens() -> None:
    action = np.full(9, 0.5)
    assert set_gripper(action, False)[schema.GRIPPER] == 0.0
    assert set_gripper(action, True)[schema.GRIPPER] == 1.0
    assert np.array_equal(set_gripper(action, None), action)
