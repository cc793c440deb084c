import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.saved.folder import find_checkpoint, inspect_checkpoint
from lerobot_llakey.saved.processors import OUR_STEPS


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "checkpoint"
    folder.mkdir()
    (folder / "config.json").write_text('{"type": "llakey_action"}')
    for name in ("policy_preprocessor.json", "policy_postprocessor.json"):
        (folder / name).write_text('{"name": "x", "steps": []}')
    header = b'{"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}'
    (folder / "model.safetensors").write_bytes(len(header).to_bytes(8, "little") + header + b"\0\0\x80\x3f")
    return folder


def _pipe(file: Path) -> None:
    file.unlink()
    os.mkfifo(file)


def _folder(file: Path) -> None:
    file.unlink()
    file.mkdir()


FILES = ["config.json", "policy_preprocessor.json", "policy_postprocessor.json", "model.safetensors"]


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize(
    "spoil",
    [
        lambda file: file.write_bytes(file.read_bytes()[:-3]),
        lambda file: file.write_bytes(b""),
        lambda file: file.write_bytes(b"\xff" + file.read_bytes()[1:]),
        lambda file: file.write_text("[" * 100_000),
        lambda file: file.write_text("[1, 2]"),
        _pipe,
        _folder,
    ],
    ids=["cut", "empty", "flipped", "nested", "a list", "a named pipe", "a folder"],
)
def test_a_broken_file_is_named(folder: Path, name: str, spoil: Callable[[Path], None]) -> None:
    assert inspect_checkpoint(folder, OUR_STEPS) == folder
    spoil(folder / name)
    with pytest.raises(LlakeyError) as caught:
        inspect_checkpoint(folder, OUR_STEPS)
    assert str(folder / name) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("settings", [{}, {"type": 5}, {"type": None}])
def test_settings_without_a_type_are_refused(folder: Path, settings: dict[str, object]) -> None:
    (folder / "config.json").write_text(json.dumps(settings))
    with pytest.raises(LlakeyError, match=r"Expected the type of a policy in .*config\.json"):
        inspect_checkpoint(folder)


def test_a_missing_checkpoint_is_told_without_a_word_of_the_hub(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder.parent)
    for path in ("/nope", "no/where/at/all", "./nope", "checkpoint/nope", "nope"):
        with pytest.raises(MissingFileError, match=r"or a Hub name, got .*, where none was found"):
            inspect_checkpoint(path)
    (folder / "config.json").unlink()
    with pytest.raises(MissingFileError, match=r"Expected a checkpoint with config\.json"):
        inspect_checkpoint(folder)


def test_a_file_in_place_of_a_folder_is_told(folder: Path) -> None:
    with pytest.raises(LlakeyError, match="which is no folder"):
        find_checkpoint(folder / "config.json")


def test_a_hub_name_that_cannot_be_fetched_is_said_as_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    with pytest.raises(LlakeyError, match="no folder here, and the Hub does not give it") as caught:
        find_checkpoint("nobody/no-checkpoint")
    assert not isinstance(caught.value, MissingFileError)
