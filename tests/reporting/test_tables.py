"""Tables count what happened."""

import pytest

from lerobot_llakey.reporting.tables import markdown_table, success_table
from lerobot_llakey.rollout.actors import Episode


def _episode(task: str, success: bool, actions: int) -> Episode:
    return Episode(task, "", 0, 0, 0, success, ["grasp the lid"] * actions, [""] * actions)


def test_success_is_counted_by_task_and_averaged_over_tasks() -> None:
    episodes = [_episode("a", True, 4), _episode("a", False, 8), _episode("b", True, 3)]
    lines = success_table(episodes).splitlines()
    assert [cell.strip() for cell in lines[2].split("|")[1:-1]] == ["a", "2", "1", "50 %", "6.0"]
    assert [cell.strip() for cell in lines[-1].split("|")[1:-1]] == ["average", "3", "", "75 %", ""]


def test_no_episodes_is_told() -> None:
    with pytest.raises(ValueError, match="Expected at least one episode"):
        success_table([])


def test_columns_line_up() -> None:
    lines = markdown_table(["name", "value"], [["a", "1"], ["longer name", "22"]]).splitlines()
    assert len({len(line) for line in lines}) == 1
    assert lines[1].startswith("|--")
