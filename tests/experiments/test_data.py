"""The paper's counts, and that no scene is collected twice."""

from collections import Counter
from pathlib import Path

from lerobot_llakey.experiments.data import Data
from lerobot_llakey.experiments.settings import DataSettings
from lerobot_llakey.sim.tasks import task_classes

TASKS = tuple(task_classes())


def test_the_papers_counts() -> None:
    data = Data(DataSettings(), TASKS, Path("somewhere"))
    action = data.training[0].settings
    assert (action.tasks, action.num_episodes) == (TASKS, 100)
    counts = Counter[str]()
    for collection in data.training:
        counts.update(dict.fromkeys(collection.settings.tasks, collection.settings.num_episodes))
    several = {name for name, task in task_classes().items() if task.sequences > 1}
    assert len(several) == 4
    assert counts == {name: 200 if name in several else 100 for name in TASKS}
    assert data.episodes == 1300
    assert data.command_root != data.action_root


def test_no_scene_twice() -> None:
    seeds: dict[str, list[int]] = {}
    for collection in Data(DataSettings(), TASKS, Path("somewhere")).training:
        for task in collection.settings.tasks:
            numbers = range(collection.settings.num_episodes)
            seeds.setdefault(task, []).extend(collection.settings.seed(number, 0) for number in numbers)
    assert all(len(set(found)) == len(found) for found in seeds.values())


def test_policies_share_a_dataset_where_their_counts_are_equal() -> None:
    data = Data(DataSettings(5, 5, 5), ("open_drawer",), Path("somewhere"))
    assert len(data.training) == 1 and data.command_root == data.action_root
