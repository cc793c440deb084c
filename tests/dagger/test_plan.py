import math

import pytest

from lerobot_llakey.dagger.plan import DaggerSettings


def test_parts_hold_every_episode_once() -> None:
    settings = DaggerSettings("x", ("a", "b"), 7)
    parts = list(settings.parts(3))
    assert parts == [("a", 0, 3), ("a", 3, 6), ("a", 6, 7), ("b", 0, 3), ("b", 3, 6), ("b", 6, 7)]
    assert len(settings) == 14 == sum(stop - start for _, start, stop in parts)


def test_what_disturbs_is_part_of_the_record_where_something_does() -> None:
    calm, dropped = DaggerSettings("x", ("a",), 7), DaggerSettings("x", ("a",), 7, disturbance="drop")
    assert dropped.resumable() == calm.resumable() | {"disturbance": "drop"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"num_episodes": 0}, "num_episodes to be a whole number from 1"),
        ({"num_episodes": 10**12}, "num_episodes .* got 1000000000000"),
        ({"image_size": 1}, "image_size"),
        ({"max_steps": 0}, "max_steps to be a whole number of 1 or more"),
        ({"expert_share": 1.5}, r"expert_share to be a number from 0 to 1, got 1\.5"),
        ({"expert_share": math.nan}, "expert_share"),
        ({"tasks": ("a", "a")}, "each task once"),
        ({"split": "holdout"}, "split"),
        ({"first_seed": -1}, "episode index"),
        ({"disturbance": "rain"}, "Expected a disturbance out of drop, .* got 'rain'"),
    ],
)
def test_bad_settings_are_refused(wrong: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        DaggerSettings(**{"policy_path": "x", "tasks": ("a",), "num_episodes": 2} | wrong)
