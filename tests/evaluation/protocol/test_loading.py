"""What decides whether results may be resumed: a checkpoint's fingerprint, and why a row cannot be run."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from fakes_action import small_config
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.evaluation.protocol.loading import runnable, why_missing
from lerobot_llakey.evaluation.protocol.rows import EXPERT, Row
from lerobot_llakey.evaluation.protocol.settings import fingerprint
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy

HEADER = b'{"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}'
WEIGHTS = len(HEADER).to_bytes(8, "little") + HEADER


@pytest.fixture
def checkpoint(tmp_path: Path) -> Path:
    folder = tmp_path / "checkpoint"
    (folder / "assets").mkdir(parents=True)
    (folder / "config.json").write_text('{"type": "llakey"}')
    (folder / "model.safetensors").write_bytes(WEIGHTS + bytes(4))
    (folder / "assets/words.txt").write_text("grasp")
    (folder / "README.md").write_text("A policy.")
    return folder


def change_a_weight(folder: Path) -> None:
    (folder / "model.safetensors").write_bytes(WEIGHTS + bytes(3) + b"\1")


def change_a_setting(folder: Path) -> None:
    (folder / "config.json").write_text('{"type": "llakez"}')


def change_what_lies_deeper(folder: Path) -> None:
    (folder / "assets/words.txt").write_text("grasq")


def rename_a_file(folder: Path) -> None:
    (folder / "assets/words.txt").rename(folder / "assets/names.txt")


def add_an_empty_file(folder: Path) -> None:
    (folder / "adapter_config.json").touch()


@pytest.mark.parametrize(
    "change", [change_a_weight, change_a_setting, change_what_lies_deeper, rename_a_file, add_an_empty_file]
)
def test_any_change_in_a_checkpoint_changes_its_fingerprint(checkpoint: Path, change: Callable[[Path], None]) -> None:
    row = Row("ours", policy_path=str(checkpoint))
    before = fingerprint(row)
    change(checkpoint)
    assert fingerprint(row) != before


def test_a_copy_elsewhere_and_another_model_card_change_nothing(checkpoint: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(checkpoint, tmp_path / "copy")
    (copy / "README.md").write_text("Another card.")
    assert fingerprint(Row("a", policy_path=str(checkpoint))) == fingerprint(Row("b", policy_path=str(copy)))


def test_both_levels_count(checkpoint: Path, tmp_path: Path) -> None:
    other = shutil.copytree(checkpoint, tmp_path / "other")
    change_a_weight(other)
    paths = [(checkpoint, checkpoint), (checkpoint, other), (other, checkpoint)]
    found = {fingerprint(Row("x", command_path=str(command), action_path=str(action))) for command, action in paths}
    assert len(found) == 3


def test_the_expert_needs_no_checkpoint_and_a_missing_one_has_no_fingerprint(tmp_path: Path) -> None:
    assert fingerprint(Row("expert", policy_path=EXPERT)) and not why_missing(Row("expert", policy_path=EXPERT))
    with pytest.raises(MissingFileError, match="nowhere"):
        fingerprint(Row("x", policy_path=str(tmp_path / "nowhere")))


def test_why_a_row_cannot_be_run_is_said(checkpoint: Path, tmp_path: Path) -> None:
    assert why_missing(Row("x", policy_path=str(checkpoint), overrides={"commander": "oracle"})) == ""
    empty = {"command.base_url": None, "command.model": "", "seed": 0}
    found = why_missing(Row("x", policy_path=str(checkpoint), overrides=empty))
    assert "command.base_url" in found and "command.model" in found and "seed" not in found
    (tmp_path / "empty").mkdir()  # a folder without a config.json is no checkpoint
    for folder in (tmp_path / "nowhere", tmp_path / "empty"):
        assert str(folder) in why_missing(Row("x", command_path=str(checkpoint), action_path=str(folder)))


@pytest.fixture
def action(tmp_path: Path) -> Path:
    LlakeyActionPolicy(small_config()).save_pretrained(tmp_path / "action")
    return tmp_path / "action"


def test_a_policy_that_was_not_trained_yet_is_missing(action: Path, tmp_path: Path) -> None:
    later = tmp_path / "later" / "checkpoints" / "last" / "pretrained_model"
    assert why_missing(Row("later", policy_path=str(later))) == f"no checkpoint at {later}"
    assert not why_missing(Row("now", policy_path=str(action)))
    assert not why_missing(Row("expert", policy_path="expert"))
    assert list(runnable([Row("now", policy_path=str(action)), Row("later", action_path=str(later))]).missing) == [
        "later"
    ]


def test_a_name_that_the_hub_does_not_give_is_an_error(action: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    rows = [Row("now", policy_path=str(action)), Row("far", policy_path="nobody/no-checkpoint")]
    with pytest.raises(LlakeyError, match="got nobody/no-checkpoint: no folder here, and the Hub does not give it"):
        runnable(rows)


def test_a_broken_checkpoint_is_an_error(action: Path) -> None:
    (action / "config.json").write_text('{"type": "llakey')
    with pytest.raises(LlakeyError, match=r"config\.json, got one that is broken"):
        why_missing(Row("broken", policy_path=str(action)))
    (action / "config.json").unlink()
    with pytest.raises(MissingFileError, match=r"Expected a checkpoint with config\.json"):
        why_missing(Row("broken", policy_path=str(action)))


def test_weights_through_a_pipe_do_not_hold_a_table_up(action: Path) -> None:
    before = fingerprint(Row("row", policy_path=str(action)))
    assert before == fingerprint(Row("row", policy_path=str(action)))
    (action / "model.safetensors").unlink()
    os.mkfifo(action / "model.safetensors")
    with pytest.raises(LlakeyError, match=r"model\.safetensors, got a named pipe"):
        fingerprint(Row("row", policy_path=str(action)))
