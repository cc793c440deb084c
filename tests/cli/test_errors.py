"""Errors as a person sees them."""

import pytest

from lerobot_llakey.cli.errors import one_sentence


def test_an_error_about_input_is_one_sentence_and_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_info, one_sentence():
        raise ValueError("Expected a cup, got a glass; take a cup.")
    assert exit_info.value.code == 1
    assert capsys.readouterr().err == "error: Expected a cup, got a glass; take a cup.\n"


def test_any_other_error_keeps_its_traceback() -> None:
    with pytest.raises(ValueError, match="broadcast"), one_sentence():
        raise ValueError("could not broadcast")
