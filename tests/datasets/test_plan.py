"""The plan fixes every episode before any is simulated."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets.balance import Balance
from lerobot_llakey.datasets.plan import ATTEMPTS, CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError

SETTINGS = CollectSettings(("open_drawer", "close_jar"), 3, split="val")


def test_tasks_take_turns() -> None:
    assert len(SETTINGS) == 6
    assert [SETTINGS.slot(index) for index in range(4)] == [
        ("open_drawer", 0),
        ("close_jar", 0),
        ("open_drawer", 1),
        ("close_jar", 1),
    ]


def test_seeds_are_of_the_split_and_never_shared() -> None:
    seeds = [SETTINGS.seed(number, attempt) for number in range(3) for attempt in range(ATTEMPTS)]
    assert len(set(seeds)) == len(seeds)
    assert all(seed in schema.SEED_RANGES["val"] for seed in seeds)


def test_more_episodes_are_the_same_plan_and_other_pictures_are_not() -> None:
    assert SETTINGS.resumable() == replace(SETTINGS, num_episodes=9).resumable()
    assert SETTINGS.resumable() != replace(SETTINGS, image_size=64).resumable()


@pytest.mark.parametrize("kinds", [("demonstrations",), ("keysteps",), ("demonstrations", "keysteps")])
def test_targets_name_what_is_asked_for(tmp_path: Path, kinds: tuple[str, ...]) -> None:
    folders = {kind: tmp_path / kind if kind in kinds else None for kind in ("demonstrations", "keysteps")}
    assert tuple(Targets(**folders).named()) == kinds


def test_shares_of_disturbed_episodes_are_kept_whatever_the_variation() -> None:
    plan = replace(SETTINGS, num_episodes=2000, recovery=0.25, execution_noise=0.25)
    drawn = [plan.disturbance(number) for number in range(2000)]
    assert drawn.count(None) / 2000 == pytest.approx(0.5, abs=0.04)
    assert drawn.count("execution_noise") / 2000 == pytest.approx(0.25, abs=0.03)
    for variation in range(20):
        assert len(set(drawn[variation::20])) == 6
    assert drawn == [replace(plan, num_episodes=1).disturbance(number) for number in range(2000)]


def test_events_are_drawn_out_of_those_asked_for() -> None:
    plan = replace(SETTINGS, recovery=1.0)
    chosen = replace(plan, events=("drop", "shift"))
    assert {chosen.disturbance(number) for number in range(100)} == {"drop", "shift"}
    assert chosen.resumable() == plan.resumable() | {"events": ["drop", "shift"]}


@pytest.mark.parametrize("events", [(), ("rain",), ("drop", "execution_noise")])
def test_what_is_no_event_is_refused(events: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match="Expected events out of drop, block, shift, empty_grasp, got "):
        replace(SETTINGS, events=events)


def test_shares_beyond_one_are_refused() -> None:
    with pytest.raises(ValueError, match="together at most 1"):
        replace(SETTINGS, recovery=0.6, execution_noise=0.6)


def test_another_balance_is_another_plan_and_the_papers_is_written_as_it_used_to_be() -> None:
    assert set(SETTINGS.resumable()) == {
        *("tasks", "split", "first_seed", "image_size", "fps", "keystep_mode", "recovery", "execution_noise")
    }
    assert SETTINGS.resumable()["keystep_mode"] == "thin"
    others = [Balance("weight"), Balance(stride=5), Balance(keyframe_repeats=3), Balance(min_per_segment=4)]
    records = [replace(SETTINGS, balance=balance).resumable() for balance in others]
    assert all(record != SETTINGS.resumable() for record in records) and records[1] != records[2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"recovery": math.nan}, "recovery to be a number from 0 to 1, got nan"),
        ({"execution_noise": -0.1}, "execution_noise to be a number from 0 to 1"),
        ({"num_episodes": 1_000_000_000_000}, "num_episodes .* got 1000000000000"),
        ({"num_episodes": 0}, "num_episodes"),
        ({"first_seed": -1}, "episode index"),
        ({"first_seed": 99_999_990, "num_episodes": 2}, "num_episodes .* to 1, got 2"),
        ({"split": "exam"}, "split"),
        ({"image_size": 1}, "image_size .* from 16 to 960"),
        ({"image_size": 100_000}, "image_size"),
        ({"image_size": 33}, "even image_size"),
        ({"fps": 0}, "fps"),
        ({"fps": 10_000}, "fps .* to 250"),
        ({"tasks": ("open_drawer", "close_jar", "open_drawer")}, "each task once"),
        ({"tasks": ()}, "each task once, got none"),
    ],
)
def test_settings_that_make_no_sense_are_refused_at_once(change: dict[str, Any], message: str) -> None:
    with pytest.raises(LlakeyError, match=message):
        replace(SETTINGS, **change)
