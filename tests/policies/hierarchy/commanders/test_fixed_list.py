import pytest

from fakes_steps import a_step
from lerobot_llakey.policies.hierarchy.commanders.fixed_list import ListCommander


def _texts(commander: ListCommander, rows: list[int]) -> list[str]:
    return [said.text for said in commander.ask({}, rows, [""] * len(rows))]


def test_gives_one_a_step_to_each_row_and_the_last_one_for_ever() -> None:
    commander = ListCommander(["a", "b", "c"])
    assert _texts(commander, [0, 1]) == _texts(commander, [0, 1]) == ["a", "a"]  # asking uses nothing up
    commander.sent([a_step(0), a_step(1, random_move=True)])
    assert _texts(commander, [1, 0]) == ["a", "b"]
    for _ in range(5):
        commander.sent([a_step(0), a_step(1, source="person")])
    assert _texts(commander, [0, 1]) == ["c", "a"]
    commander.reset()
    assert _texts(commander, [0, 1]) == ["a", "a"]


def test_an_empty_list_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one instruction"):
        ListCommander([])
