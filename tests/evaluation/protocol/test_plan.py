"""The episodes of a table: none twice, scenes shared by the rows alone."""

import pytest

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import Row


def test_the_papers_counts() -> None:
    plan = Plan(("open_drawer", "close_jar"))
    trials = plan.trials([Row("a", "x"), Row("b", "y")])
    assert len(trials) == 2 * plan.episodes_a_row == 2 * 2 * 25 * 6
    assert len({trial.key for trial in trials}) == len(trials)
    of_a_task = [trial.scene for trial in trials if trial.row == "a" and trial.task == "close_jar"]
    assert sorted(of_a_task) == list(range(150))
    assert of_a_task == [trial.scene for trial in trials if trial.row == "b" and trial.task == "close_jar"]


def test_events_are_parts_of_their_own() -> None:
    trials = Plan(("open_drawer",), 2, 1, disturbances=("drop", "shift")).trials([Row("a", "x")])
    assert [(trial.disturbance, trial.episode) for trial in trials] == [
        ("drop", 0),
        ("drop", 1),
        ("shift", 0),
        ("shift", 1),
    ]
    assert str(trials[2]) == "episode 0 of repeat 0 of open_drawer under shift (scene 0) in the row 'a'"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"num_episodes": 0}, "num_episodes, repeats and max_steps"),
        ({"repeats": -1}, "num_episodes, repeats and max_steps"),
        ({"split": "exam"}, "Expected a split"),
        ({"first_seed": -1}, "episode index"),
        ({"first_seed": 99_999_990}, "episode index"),
        ({"disturbances": ("quake",)}, "Expected a disturbance"),
    ],
)
def test_what_cannot_be_run_is_told(settings: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Plan(("open_drawer",), **settings)
