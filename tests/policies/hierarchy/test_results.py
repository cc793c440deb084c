"""The figures of an evaluation, in each form in which they are written."""

import json
from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.results import known_results, read_results, results_table


def test_counts_successes_by_task() -> None:
    episodes = [{"task": task, "success": done} for task, done in (("a", True), ("b", True), ("a", False))]
    table = results_table({"episodes": episodes}).splitlines()
    assert table[2:] == ["| `a` | 2 | 1 (50 %) |", "| `b` | 1 | 1 (100 %) |", "| average | 3 | 75 % |"]


def test_takes_a_finished_table_as_it_is() -> None:
    assert results_table({"markdown": "| a |\n|---|\n", "episodes": []}) == "| a |\n|---|"


def test_shows_the_rows_of_a_table_with_their_spread() -> None:
    half, all_ = {"success": 0.5, "spread": 0.04}, {"success": 1.0, "spread": 0.0}
    rows = {
        "LLaKey": {"tasks": {"a": half, "b": all_}, "average": half},
        "RVT": {"tasks": {"b": half}, "average": half},
    }
    assert results_table({"rows": rows, "settings": {}}).splitlines() == [
        "| success | `a` | `b` | average |",
        "|---|---|---|---|",
        "| LLaKey | 50.0 ± 4.0 | 100.0 ± 0.0 | 50.0 ± 4.0 |",
        "| RVT |  | 50.0 ± 4.0 | 50.0 ± 4.0 |",
    ]


@pytest.mark.parametrize(
    "results",
    [
        {},
        {"per_group": {"a": {"pc_success": 1.0}}},
        {"rows": [1]},
        {"rows": {"LLaKey": {"shift": {}}}},
        {"episodes": []},
        {"episodes": [{"task": "a"}]},
        [1],
    ],
)
def test_other_figures_are_refused(results, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="Expected results with a table under 'markdown'"):
        results_table(results)
    (tmp_path / "results.json").write_text(json.dumps(results))
    with pytest.raises(ValueError, match=r"results\.json: Expected results"):
        read_results(tmp_path)


def test_the_setting_comes_before_the_folder(tmp_path: Path) -> None:
    assert known_results(None, None) is known_results(None, tmp_path) is None
    (tmp_path / "results.json").write_text(json.dumps({"markdown": "of the folder"}))
    (tmp_path / "other.json").write_text(json.dumps({"markdown": "of the setting"}))
    assert known_results(None, tmp_path) == "of the folder"
    assert known_results(str(tmp_path / "other.json"), tmp_path) == "of the setting"
    with pytest.raises(FileNotFoundError, match="Expected the results of an evaluation at"):
        known_results(str(tmp_path / "nowhere.json"), tmp_path)


def test_shows_what_lerobot_eval_wrote(tmp_path: Path) -> None:
    figures = {"pc_success": 75.0, "n_episodes": 4}
    written = {"per_task": [], "per_group": {"close_jar": figures}, "overall": figures}
    (tmp_path / "eval_info.json").write_text(json.dumps(written))
    assert read_results(tmp_path / "eval_info.json").splitlines()[2:] == [
        "| `close_jar` | 4 | 75 % |",
        "| overall | 4 | 75 % |",
    ]


def test_a_file_that_is_cut_off_is_said(tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text('{"rows": ')
    with pytest.raises(LlakeyError, match=r"Expected .*JSON file.*results\.json"):
        read_results(tmp_path)
