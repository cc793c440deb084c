import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor, SupervisorSettings


def _supervisor(seed: int = 0, **settings) -> Supervisor:
    return Supervisor(SupervisorSettings(**settings), np.random.default_rng(seed))


def _action(gripper: float = 1.0) -> np.ndarray:
    return np.array([0.4, 0.1, 0.3, 2.0, 0.0, 0.0, 0.0, gripper, 1.0], dtype=np.float32)


def _state(opening: float = 1.0) -> np.ndarray:
    return np.array([0.5, -0.1, 0.4, 0.0, 1.0, 0.0, 0.0, opening, *[0.0] * 7], dtype=np.float32)


def test_counts_repeats_whatever_the_wording_and_starts_anew_with_another_instruction() -> None:
    supervisor = _supervisor()
    seen = []
    for text in ("grasp the lid", "grab the lid", "Grasp the lid.", "raise the robotic arm", "grasp the lid"):
        supervisor.accept(text)
        seen.append(supervisor.repeats)
    assert seen == [0, 1, 2, 0, 0]
    assert supervisor.previous == "grasp the lid"


def test_keeps_the_last_valid_instruction_and_counts_the_rest() -> None:
    supervisor = _supervisor()
    assert supervisor.accept("gibberish") == "raise the robotic arm"
    assert supervisor.accept("grasp the lid") == "grasp the lid"
    assert supervisor.accept("grasp") == "grasp the lid"
    assert supervisor.accept("") == "grasp the lid"
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
    supervisor.accept(text)
    adjusted = supervisor.adjust(_action(given), _state())
    assert adjusted[schema.GRIPPER] == expected
    assert np.allclose(adjusted[[0, 1, 2, 8]], _action()[[0, 1, 2, 8]])


def test_quaternions_come_out_at_unit_length_and_zeros_are_refused() -> None:
    supervisor = _supervisor()
    supervisor.accept("raise the robotic arm")
    assert np.allclose(supervisor.adjust(_action(), _state())[schema.QUATERNION], [1, 0, 0, 0])
    with pytest.raises(ValueError, match="non-zero length"):
        supervisor.adjust(np.zeros(9), _state())


def test_random_moves_begin_past_the_threshold_and_start_the_count_anew() -> None:
    supervisor = _supervisor(repeat_threshold=2, random_move_probability=1.0)
    moved = []
    for _ in range(9):
        supervisor.accept("slide the block to the mark")
        supervisor.adjust(_action(), _state())
        moved.append(supervisor.random_moves)
    assert moved == [0, 0, 0, 1, 1, 1, 2, 2, 2]


def test_random_moves_stay_near_the_gripper_and_keep_hand_and_grasp() -> None:
    supervisor = _supervisor(repeat_threshold=0, random_move_probability=1.0, random_move_radius=0.1)
    distances = []
    supervisor.accept("grasp the lid")
    supervisor.adjust(_action(), _state(opening=0.6))
    for _ in range(200):
        supervisor.accept("pull the lid out")
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
    supervisor = _supervisor(free_text=True, repeat_threshold=0, random_move_probability=1.0)
    for _ in range(5):
        assert supervisor.accept("open the top drawer") == "open the top drawer"
        assert np.allclose(supervisor.adjust(_action(), _state())[:3], _action()[:3])
    assert (supervisor.repeats, supervisor.unparsable, supervisor.random_moves) == (0, 0, 0)
