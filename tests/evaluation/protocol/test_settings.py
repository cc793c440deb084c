"""A folder's results stay of one setting."""

from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.settings import claim, settings_of

PLAN = Plan(("open_drawer",), 2, 3)


@pytest.fixture
def checkpoint(tmp_path: Path) -> Path:
    folder = tmp_path / "some" / "check" / "point"
    folder.mkdir(parents=True)
    (folder / "config.json").write_text("{}")
    (folder / "model.safetensors").write_bytes(bytes(100))
    return folder


def test_the_same_settings_go_on(tmp_path: Path, checkpoint: Path) -> None:
    for _ in range(2):
        claim(tmp_path, settings_of(PLAN, [Row("a", str(checkpoint), overrides={"seed": 1})], {}))


def test_other_weights_are_noticed(tmp_path: Path, checkpoint: Path) -> None:
    row = Row("a", str(checkpoint))
    claim(tmp_path, settings_of(PLAN, [row], {}))
    (checkpoint / "README.md").write_text("words do not count")
    claim(tmp_path, settings_of(PLAN, [row], {}))
    (checkpoint / "model.safetensors").write_bytes(bytes(99) + b"\1")
    with pytest.raises(ValueError, match="a change of weights of the row 'a'"):
        claim(tmp_path, settings_of(PLAN, [row], {}))


@pytest.mark.parametrize(
    ("plan", "row", "words"),
    [
        (Plan(("open_drawer",), 3, 3), Row("a", "expert"), "a change of num_episodes;"),
        (Plan(("close_jar",), 2, 3, split="val"), Row("a", "expert"), "a change of tasks, split;"),
        (PLAN, Row("b", "expert"), r"a change of rows \(they were a\)"),
        (PLAN, Row("a", "expert", overrides={"commander": "oracle"}), "a change of overrides of the row 'a'"),
    ],
)
def test_other_settings_are_noticed(tmp_path: Path, plan: Plan, row: Row, words: str) -> None:
    claim(tmp_path, settings_of(PLAN, [Row("a", "expert")], {}))
    with pytest.raises(ValueError, match=words):
        claim(tmp_path, settings_of(plan, [row], {}))


def test_a_checkpoint_may_come_later_but_not_go(tmp_path: Path, checkpoint: Path) -> None:
    row = Row("a", str(checkpoint))
    claim(tmp_path, settings_of(PLAN, [row], {"a": "no checkpoint"}))
    claim(tmp_path, settings_of(PLAN, [row], {}))
    with pytest.raises(ValueError, match="weights of the row 'a'"):
        claim(tmp_path, settings_of(PLAN, [row], {"a": "no checkpoint"}))


@pytest.mark.parametrize("content", ['{"plan": {}, "ro', "[]"])
def test_a_broken_record_is_named(tmp_path: Path, checkpoint: Path, content: str) -> None:
    (tmp_path / "settings.json").write_text(content)
    with pytest.raises(LlakeyError, match=r"Expected a readable record of a table at .*settings\.json"):
        claim(tmp_path, settings_of(PLAN, [Row("a", str(checkpoint))], {}))
