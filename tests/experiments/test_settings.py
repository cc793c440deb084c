"""Scales and where their files are found."""

from pathlib import Path

import pytest

from lerobot_llakey.experiments.settings import AmbiguitySettings, DataSettings, find_config


def test_recipes_are_found_wherever_one_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert find_config("configs/action_small.yaml").is_file()
    own = tmp_path / "mine.yaml"
    own.write_text("a: 1")
    assert find_config(str(own)) == own


def test_a_missing_file_is_named() -> None:
    with pytest.raises(FileNotFoundError, match=r"got configs/reproduce_huge\.yaml"):
        find_config("configs/reproduce_huge.yaml")


def test_fewer_demonstrations_for_the_command_than_for_the_action_policy_are_refused() -> None:
    with pytest.raises(ValueError, match="action_episodes <= command_episodes"):
        DataSettings(action_episodes=10, command_episodes=5)


def test_an_unknown_test_is_refused() -> None:
    with pytest.raises(ValueError, match="Expected tests out of as_trained"):
        AmbiguitySettings(tests=["shouted"])
