"""Tasks are found by name, and say enough about themselves."""

import pytest

from lerobot_llakey.sim import tasks
from lerobot_llakey.sim.tasks import make_task, parse_tasks, register_task, task_classes
from lerobot_llakey.sim.tasks.base import Task
from lerobot_llakey.sim.tasks.open_drawer import OpenDrawer


def test_names_are_found_and_lists_are_read() -> None:
    assert isinstance(make_task("open_drawer"), Task)
    assert parse_tasks("open_drawer, close_jar") == ["open_drawer", "close_jar"]
    assert parse_tasks("all") == list(task_classes())


def test_a_task_comes_once() -> None:
    with pytest.raises(ValueError, match="got 'open_drawer' twice"):
        parse_tasks("open_drawer, open_drawer")


@pytest.mark.parametrize("names", ["", "open_drawer,fold_laundry"])
def test_unknown_names_are_told(names: str) -> None:
    with pytest.raises(ValueError, match="Expected tasks out of"):
        parse_tasks(names)


@pytest.mark.parametrize("name", task_classes())
def test_every_task_counts_its_variations_and_sequences(name: str) -> None:
    task = make_task(name)
    assert task.name == name and task.variations >= task.sequences >= 1


def test_a_task_of_ones_own_is_known_once_registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tasks, "_REGISTERED", {})

    class Mine(OpenDrawer):
        name = "mine"

    with pytest.raises(ValueError, match="got 'mine'"):
        make_task("mine")
    assert register_task(Mine) is Mine is register_task(Mine)
    assert isinstance(make_task("mine"), Mine) and "mine" in parse_tasks("all")


def test_a_task_of_ones_own_takes_no_others_name() -> None:
    class Mine(OpenDrawer):
        pass

    with pytest.raises(ValueError, match=r"got 'open_drawer', which is lerobot_llakey.*OpenDrawer; name it otherwise"):
        register_task(Mine)
