import pytest

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.commanders.commander import Said
from lerobot_llakey.policies.hierarchy.commanders.task import TaskCommander


def test_says_the_skill_instruction() -> None:
    commander = TaskCommander()
    assert commander.ask({schema.TASK: ["open it", "close it"]}, [1], [""]) == [Said("close it", "task")]
    assert commander.ask({schema.TASK: "open it"}, [0, 1], ["", ""]) == [Said("open it", "task")] * 2


def test_a_missing_task_is_named() -> None:
    with pytest.raises(ValueError, match="Expected 'task' in the batch, got"):
        TaskCommander().ask({}, [0], [""])
