"""Errors as a person sees them."""

import errno
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import draccus
import pytest
from lerobot.configs.policies import PreTrainedConfig

import lerobot_llakey  # noqa: F401 - registers the policies
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.errors import LlakeyError


def test_an_error_about_input_is_one_sentence_and_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_info, one_sentence():
        raise LlakeyError("Expected a cup, got a glass; take a cup.")
    assert exit_info.value.code == 1
    assert capsys.readouterr().err == "error: Expected a cup, got a glass; take a cup.\n"


def test_any_other_error_keeps_its_traceback() -> None:
    with pytest.raises(ValueError, match="one shape"), one_sentence():
        raise ValueError("Expected arrays of one shape")


def test_settings_read_from_a_file_give_the_sentence_of_their_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = tmp_path / "config.yaml"
    settings.write_text("type: llakey\nrepeat_threshold: -3\n")
    with pytest.raises(SystemExit), one_sentence():
        draccus.parse(PreTrainedConfig, str(settings), args=[])
    assert capsys.readouterr().err.startswith("error: Expected repeat_threshold to be a whole number")


def test_a_setting_of_another_type_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    settings = tmp_path / "config.yaml"
    settings.write_text("type: llakey\nrepeat_threshold: often\n")
    with pytest.raises(SystemExit), one_sentence():
        draccus.parse(PreTrainedConfig, str(settings), args=[])
    said = capsys.readouterr().err
    assert said.startswith("error: Expected options") and "often" in said and said.count("\n") == 1


def test_a_refusal_of_the_file_system_names_the_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit), one_sentence():
        (tmp_path / "file" / "folder").mkdir()
    said = capsys.readouterr().err
    assert str(tmp_path / "file" / "folder") in said and "not a directory" in said and said.count("\n") == 1


def test_a_system_error_that_names_no_place_keeps_its_traceback() -> None:
    with pytest.raises(OSError, match="unclear"), one_sentence():
        raise OSError("unclear")


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), "no space left on device"),
        (BrokenProcessPool("A child process terminated abruptly"), "one killed"),
    ],
)
def test_a_full_disk_and_a_killed_process_are_one_sentence(
    error: Exception, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit), one_sentence():
        raise error
    assert said in (sentence := capsys.readouterr().err) and sentence.startswith("error: Expected")
