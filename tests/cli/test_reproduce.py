"""``llakey reproduce``: a scale is the name of a file, unless a file is given."""

import pytest

from lerobot_llakey.cli.reproduce import with_scale_file


def test_a_scale_names_its_file() -> None:
    first, *rest = with_scale_file(["--scale=toy", "--plan_only=true"])
    assert first.startswith("--config_path=") and first.endswith("configs/reproduce_toy.yaml")
    assert rest == ["--scale=toy", "--plan_only=true"]


def test_a_file_of_ones_own_is_taken_as_it_is() -> None:
    arguments = ["--config_path=mine.yaml", "--table.repeats=2"]
    assert with_scale_file(arguments) == arguments


def test_help_needs_no_file() -> None:
    assert with_scale_file(["--help"]) == ["--help"]


def test_an_unknown_scale_is_one_sentence() -> None:
    with pytest.raises(FileNotFoundError, match="got configs/reproduce_huge"):
        with_scale_file(["--scale=huge"])
