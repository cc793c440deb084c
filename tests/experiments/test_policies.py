"""Which rows a reproduction has."""

from pathlib import Path

import pytest

from lerobot_llakey.experiments.data import Data
from lerobot_llakey.experiments.policies import BASELINE_ROW, LLAKEY_ROW, Policies
from lerobot_llakey.experiments.settings import DataSettings, TableSettings, TrainingSettings, TrainSettings
from lerobot_llakey.reporting.paper_results import SUCCESS


def policies(**recipes: str) -> Policies:
    train = TrainSettings(**{name: TrainingSettings(recipe) for name, recipe in recipes.items()})
    return Policies(train, Data(DataSettings(), ("open_drawer",), Path("data")), Path("out"))


def test_all_rows_of_the_paper() -> None:
    five = dict.fromkeys(("action", "command", "baseline", "one_view", "direct"), "configs/action_small.yaml")
    whole = policies(**five)
    rows = whole.rows(TableSettings(chat_url="http://127.0.0.1:8000/v1", chat_model="m"))
    assert [row.name for row in rows] == [
        LLAKEY_ROW,
        "LLaKey (1 view)",
        "LLaKey with the oracle's instructions",
        BASELINE_ROW,
        "direct action prediction",
        "chat model",
    ]
    assert {row.paper for row in rows} - {""} <= set(SUCCESS)
    assert rows[-1].overrides["command.base_url"] == "http://127.0.0.1:8000/v1"
    assert [row.name for row in whole.rollback_rows()] == [LLAKEY_ROW, BASELINE_ROW]
    assert list(whole.commanders()) == ["3 views", "1 view"]


def test_a_policy_without_a_recipe_is_left_out() -> None:
    some = policies(action="a.yaml", command="c.yaml")
    assert [row.name for row in some.rows(TableSettings())] == [LLAKEY_ROW, "LLaKey with the oracle's instructions"]


def test_both_levels_are_needed() -> None:
    with pytest.raises(ValueError, match=r"Expected recipes for train\.action and train\.command"):
        policies(action="a.yaml")
