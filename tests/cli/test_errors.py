"""Errors as a person sees them."""

from pathlib import Path

import draccus
import pytest
from draccus.utils import ParsingError
from lerobot.configs.policies import PreTrainedConfig

import lerobot_llakey  # noqa: F401 - registers the policies
from lerobot_llakey.cli.errors import one_sentence


def test_an_error_about_input_is_one_sentence_and_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_info, one_sentence():
        raise ValueError("Expected a cup, got a glass; take a cup.")
    assert exit_info.value.code == 1
    assert capsys.readouterr().err == "error: Expected a cup, got a glass; take a cup.\n"


def test_any_other_error_keeps_its_traceback() -> None:
    with pytest.raises(ValueError, match="broadcast"), one_sentence():
        raise ValueError("could not broadcast")


def test_settings_read_from_a_file_give_the_sentence_of_their_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = tmp_path / "config.yaml"
    settings.write_text("type: llakey\nrepeat_threshold: -3\n")
    with pytest.raises(SystemExit), one_sentence():
        draccus.parse(PreTrainedConfig, str(settings), args=[])
    assert capsys.readouterr().err.startswith("error: Expected repeat_threshold >= 0")


def test_any_other_parsing_error_keeps_its_traceback(tmp_path: Path) -> None:
    settings = tmp_path / "config.yaml"
    settings.write_text("type: llakey\nrepeat_threshold: often\n")
    with pytest.raises(ParsingError), one_sentence():
        draccus.parse(PreTrainedConfig, str(settings), args=[])
