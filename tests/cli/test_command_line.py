"""Options from a command line and a file, or handed over as they are."""

import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from lerobot_llakey.cli.command_line import parse, with_options
from lerobot_llakey.errors import LlakeyError


@dataclass
class Options:
    task: str
    num_episodes: int = 2
    constrain: bool | None = None
    output_dir: Path | None = None


@with_options
def run(config: Options) -> Options:
    return config


def test_options_come_from_the_command_line_or_as_they_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "argv", ["llakey", "--task=close_jar", "--num_episodes", "3", f"--output_dir={tmp_path}"])
    assert run() == Options("close_jar", 3, None, tmp_path)
    assert run(Options("open_drawer")) == Options("open_drawer")


def test_a_file_gives_options_and_the_command_line_changes_them(tmp_path: Path) -> None:
    file = tmp_path / "options.yaml"
    file.write_text("task: close_jar\nnum_episodes: 5\n")
    assert parse(Options, [f"--config_path={file}", "--constrain=true"]) == Options("close_jar", 5, True)
    assert parse(Options, ["--num_episodes=7", f"--config_path={file}"]) == Options("close_jar", 7)


def test_a_broken_file_is_named(tmp_path: Path) -> None:
    file = tmp_path / "options.yaml"
    file.write_bytes(b"task: [\xff")
    with pytest.raises(LlakeyError, match=f"Expected a readable YAML file of options at {file}"):
        parse(Options, [f"--config_path={file}"])


@pytest.mark.parametrize("bad", [-1, 0, 1.5])
def test_options_handed_over_are_held_against_the_rules_too(bad: int) -> None:
    with pytest.raises(LlakeyError, match="Expected --num_episodes"):
        run(Options("open_drawer", bad))
