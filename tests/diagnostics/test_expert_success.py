"""The experts' figures: trials, summary and table."""

from dataclasses import replace

import pytest

from lerobot_llakey import schema
from lerobot_llakey.diagnostics.expert_success import Trial, evaluate_experts, summarise, table


def trial(seed: int, *, success: bool = True, match: bool = True) -> Trial:
    return Trial("open_drawer", seed, seed % 3, 0, success, match, 3, () if success else ("collision",))


def test_the_expert_opens_unseen_drawers_of_each_variation() -> None:
    trials = evaluate_experts(["open_drawer"], 3, split="val", num_workers=1)
    assert [found.seed for found in trials] == [schema.scene_seed("val", index) for index in range(3)]
    assert [found.variation for found in trials] == [0, 1, 2]
    assert all(found.success and found.actions >= 3 for found in trials)


def test_the_summary_counts_shares_and_names_the_seeds_that_failed() -> None:
    row = summarise([trial(0), trial(1), trial(2, success=False, match=False), trial(3, match=False)])["open_drawer"]
    assert row["episodes"] == 4
    assert row["success"] == pytest.approx(0.75)
    assert row["keyframes_match"] == pytest.approx(2 / 3)
    assert (row["variations_met"], row["variations"]) == (3, 3)
    assert (row["sequences_met"], row["sequences"]) == (1, 1)
    assert row["failures"] == {"collision": 1}
    assert (row["failed_seeds"], row["mismatched_seeds"]) == ([2], [3])


def test_the_table_has_a_line_a_task() -> None:
    lines = table(summarise([trial(0), trial(1, success=False)])).splitlines()
    assert lines[0].split() == [
        "task",
        "episodes",
        "success",
        "keyframes",
        "variations",
        "sequences",
        "actions",
        "no",
        "path",
    ]
    assert lines[1].split() == ["open_drawer", "2", "50.0%", "100.0%", "2/3", "1/1", "3.0", "1"]


def test_an_unknown_split_is_refused() -> None:
    with pytest.raises(ValueError, match="Expected a split"):
        evaluate_experts(["open_drawer"], 1, split="exam")


def test_recovery_is_counted_where_a_disturbance_struck() -> None:
    trials = evaluate_experts(["open_drawer"], 3, split="val", num_workers=1, disturbance="shift")
    assert all(found.struck for found in trials)
    row = summarise([replace(trials[0], success=False), *trials[1:], trial(3)])["open_drawer"]
    assert (row["struck"], row["recovered"]) == (3, pytest.approx(2 / 3))
    assert table({"open_drawer": row}).splitlines()[0].split()[-2:] == ["struck", "recovered"]


def test_an_unknown_disturbance_is_refused() -> None:
    with pytest.raises(ValueError, match="Expected a disturbance"):
        evaluate_experts(["open_drawer"], 1, disturbance="earthquake")
