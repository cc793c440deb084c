"""The llakey command: help, dispatch and the sentence for a verb that does not exist."""

import importlib
import sys
import types

import pytest

from lerobot_llakey.cli import main as cli


@pytest.fixture
def echo(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """A verb ``echo`` whose module notes the arguments that it finds."""
    calls: list[list[str]] = []
    module = types.ModuleType("llakey_echo")
    module.main = lambda: calls.append(list(sys.argv))  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "llakey_echo", module)
    monkeypatch.setitem(cli.VERBS, "echo", ("llakey_echo", "say it again"))
    monkeypatch.setattr(sys, "argv", ["llakey"])
    return calls


@pytest.mark.parametrize("verb", list(cli.VERBS))
def test_every_listed_verb_has_a_module_with_main_and_a_one_line_summary(verb: str) -> None:
    module, summary = cli.VERBS[verb]
    assert callable(importlib.import_module(module).main)
    assert summary and "\n" not in summary


def test_a_verb_finds_its_options_in_argv(echo: list[list[str]]) -> None:
    cli.main(["echo", "--task=open_drawer", "--num_episodes=3"])
    assert echo == [["llakey echo", "--task=open_drawer", "--num_episodes=3"]]


def test_help_of_a_verb_is_the_verbs_own(echo: list[list[str]]) -> None:
    cli.main(["echo", "--help"])
    assert echo == [["llakey echo", "--help"]]


@pytest.mark.parametrize("flag", ["--help", "-h", "help"])
def test_help_lists_every_verb_with_its_summary(
    flag: str, echo: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_info:
        cli.main([flag])
    assert exit_info.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    for verb, (_, summary) in cli.VERBS.items():
        assert any(line.split() == [verb, *summary.split()] for line in lines)
    assert echo == []


def test_without_a_verb_the_help_goes_to_stderr(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_info:
        cli.main([])
    assert exit_info.value.code == 2
    assert "usage: llakey" in capsys.readouterr().err


def test_an_unknown_verb_names_the_nearest_in_one_sentence(
    echo: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_info:
        cli.main(["ehco", "--task=open_drawer"])
    assert exit_info.value.code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "got 'ehco'; did you mean 'echo'?" in error
    assert echo == []


def test_a_verb_unlike_any_other_points_to_the_help() -> None:
    assert "llakey --help" in cli.unknown_verb("xyzzy", {"collect": ("module", "summary")})


@pytest.mark.parametrize(("verb", "then"), [("echo", "begins anew"), ("table", "goes on where it was")])
def test_ctrl_c_ends_a_verb_with_one_line(
    verb: str, then: str, echo: list[list[str]], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(cli.VERBS, verb, ("llakey_echo", ""))
    monkeypatch.setattr(sys.modules["llakey_echo"], "main", interrupted)
    with pytest.raises(SystemExit) as exit_info:
        cli.main([verb])
    said = capsys.readouterr().err
    assert exit_info.value.code == 130 and f"llakey {verb}: interrupted; " in said and then in said
    assert said.strip().count("\n") == 0


def test_every_verb_that_goes_on_is_a_verb() -> None:
    assert set(cli.RESUMED) <= set(cli.VERBS)
