"""Scores of the rules, over recordings and as a table."""

import pytest

from lerobot_llakey import schema
from lerobot_llakey.diagnostics.keyframe_rules import SENSORS, Score, measure_rules, score_episode, summary, table
from lerobot_llakey.errors import LlakeyError


def score(rules: str = "waypoints", *, success: bool = True, right: int = 3, replayed: bool | None = None) -> Score:
    return Score("open_drawer", 5000, "10 fps, 1 mrad", rules, success, 4, 5, right, [4, 3, 2], replayed)


def test_every_choice_of_rules_is_scored() -> None:
    scores = score_episode("open_drawer", "train", 5000, ("rest", "waypoints"), ("waypoints",))
    assert [one.rules for one in scores] == ["rest", "waypoints"]
    assert scores[0].replayed is None and scores[1].replayed is not None
    assert summary(scores[1:])["recall"] > 0.5


def test_scores_come_by_rules_and_ways_to_record_take_turns() -> None:
    scores = measure_rules(["open_drawer"], 2, ["speed", "rest"], split="train", first_seed=4, num_workers=1)
    assert [one.rules for one in scores] == ["speed", "speed", "rest", "rest"]
    assert [one.seed for one in scores[:2]] == [schema.scene_seed("train", 4), schema.scene_seed("train", 5)]
    assert [one.sensors for one in scores[:2]] == [list(SENSORS)[4], next(iter(SENSORS))]


def test_an_unknown_rule_is_refused_before_anything_is_recorded() -> None:
    with pytest.raises(LlakeyError, match="'corners'"):
        measure_rules(["open_drawer"], 1, ["rest"], ["corners"])


def test_recordings_whose_task_failed_do_not_count() -> None:
    row = summary([score(), score(success=False, right=0)])
    assert (row["episodes"], row["keyframes"]) == (1, 5)
    assert row["recall"] == pytest.approx(3 / 5)
    assert row["false"] == pytest.approx(1 / 4)
    assert row["F1@50"] == pytest.approx(4 / 9)
    assert "replayed" not in row


def test_the_share_replayed_is_of_those_tried() -> None:
    row = summary([score(replayed=True), score(replayed=False), score(replayed=True), score()])
    assert row["replayed"] == pytest.approx(2 / 3)


def test_the_table_has_all_recordings_then_each_way_to_record() -> None:
    lines = table([score("rest"), score(replayed=True)]).splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]
    assert [line[:2] for line in cells] == [
        ["rest", "all"],
        ["rest", "10 fps, 1 mrad"],
        ["waypoints", "all"],
        ["waypoints", "10 fps, 1 mrad"],
    ]
    assert cells[0][4:6] == ["60.0%", "25.0%"]
    assert [line[-1] for line in cells] == ["", "", "100.0%", "100.0%"]
