"""Every verb with values that make no sense: one sentence, before anything is loaded, simulated or written."""

import importlib
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest

from lerobot_llakey.cli import main as cli
from lerobot_llakey.cli.options import RULES
from lerobot_llakey.experiments.stages import Ledger
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.sim.simulation import Simulation

NEEDED: dict[str, list[str]] = {
    "abilities": ["--policy_path=none", "--repo_id=l/x"],
    "ambiguity": [],
    "bench": ["--part=render"],
    "compose": ["--output_dir=out", "--command_path=none", "--action_path=none"],
    "contact-sheet": ["--output=out.png"],
    "demo": ["--policy_path=expert"],
    "determinism": [],
    "drive": ["--terminal"],
    "expert": [],
    "keyframe-accuracy": ["--policy_path=none", "--repo_id=l/x"],
    "reproduce": [],
    "rollback": ["--rows=expert"],
    "show": ["--policy_path=none", "--repo_id=l/x"],
    "stress": [],
    "table": ["--rows=expert"],
}
"""Verbs whose options are held against the rules, with what they need."""
HUGE = "1000000000000"
WRONG: dict[str, tuple[str, ...]] = {
    "abilities_root": ("no/such/folder",),
    "abilities_samples": ("0",),
    "actions": ("-1", "1000000"),
    "batch_size": ("0", "-4", "nan"),
    "device": ("abacus", ""),
    "disturbance": ("earthquake",),
    "first_seed": ("-1", HUGE, "99999999"),
    "index": ("-1", "first"),
    "max_samples": ("0", "-3"),
    "max_steps": ("0", "-1"),
    "num_actions": ("0", "-1", HUGE),
    "num_demos": ("-1", HUGE),
    "num_episodes": ("0", "-1", HUGE, "nan", "two", "1.5"),
    "num_samples": ("-1",),
    "samples": ("0", "-1"),
    "num_videos": ("-1",),
    "num_workers": ("-1", "1000000", "1.5"),
    "output": ("FILE/under.png", "FOLDER", "FOLDER.png", "page.jpg", "/proc/llakey/page.png"),
    "output_dir": ("FILE", "FILE/under", "LINK", "LINK/under", "/proc/llakey"),
    "part": ("all", ""),
    "pause_seconds": ("nan", "-1", "inf"),
    "port": ("-1", "99999", "http"),
    "repeats": ("0", "-2"),
    "rerun": ("page.png", "FILE/under.rrd"),
    "seed": ("-1", HUGE, "x"),
    "side_by_side": ("0",),
    "split": ("trial", ""),
    "steps": ("0", "-1"),
    "task": ("", ",", "no_such", "open_drawer,open_drawer", "["),
}
"""FILE, FOLDER, FOLDER.png and LINK (dangling) are made beforehand."""


def _options(verb: str) -> dict[str, Any]:
    """Names and types of a verb's options."""
    module = importlib.import_module(cli.VERBS[verb][0])
    own = [kind for kind in vars(module).values() if is_dataclass(kind) and kind.__module__ == module.__name__]
    hints = get_type_hints(own[0])
    return {part.name: hints[part.name] for part in fields(own[0])}


@pytest.fixture
def idle(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """An empty folder, and a failure wherever work would begin."""
    (tmp_path / "FILE").touch()
    (tmp_path / "FOLDER").mkdir()
    (tmp_path / "FOLDER.png").mkdir()
    (tmp_path / "LINK").symlink_to(tmp_path / "no" / "where")
    monkeypatch.chdir(tmp_path)
    for kind, name in ((Simulation, "__init__"), (Agent, "load"), (ProcessPoolExecutor, "__init__"), (Ledger, "check")):
        monkeypatch.setattr(kind, name, lambda *_, **__: pytest.fail("work was begun"))


def _said(capsys: pytest.CaptureFixture[str], verb: str, *options: str) -> str:
    """The one sentence with which a verb ends."""
    with pytest.raises(SystemExit) as ended:
        cli.main([verb, *options])
    said = capsys.readouterr().err
    assert ended.value.code == 1 and said.startswith("error: Expected") and said.count("\n") == 1, said
    return said


@pytest.mark.parametrize("verb", NEEDED)
def test_values_that_make_no_sense(verb: str, idle: None, capsys: pytest.CaptureFixture[str]) -> None:
    tried = 0
    for option in _options(verb):
        for value in WRONG.get(option, ()):
            if (verb, option) == ("compose", "split"):
                continue
            kept = [given for given in NEEDED[verb] if not given.startswith(f"--{option}=")]
            said = _said(capsys, verb, *kept, f"--{option}={value}")
            assert value.partition("/")[0] in said or "Expected options that can be read" in said or value in ("", ",")
            tried += 1
    assert tried or verb == "compose"
    assert not list(Path().glob("out*"))


@pytest.mark.parametrize("verb", NEEDED)
def test_options_that_cannot_be_read(verb: str, idle: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert "got '--no_such_option'" in _said(capsys, verb, *NEEDED[verb], "--no_such_option=1")
    assert "no/such.yaml" in _said(capsys, verb, *NEEDED[verb], "--config_path=no/such.yaml")
    _said(capsys, verb, *NEEDED[verb], "stray")
    _said(capsys, verb, "--")


@pytest.mark.parametrize("verb", NEEDED)
def test_help_lists_every_option(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main([verb, "--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert all(f"--{option}" in said for option in _options(verb))


@pytest.mark.parametrize("verb", NEEDED)
def test_every_number_and_every_place_to_write_to_has_a_rule_and_a_wrong_value(verb: str) -> None:
    for option, kind in _options(verb).items():
        kinds = set(get_args(kind)) or {kind}
        if kinds & {int, float} or option.startswith("output"):
            assert option in RULES and option in WRONG, option


def test_an_option_of_a_nearly_right_name_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert "got '--num_episode'; did you mean --num_episodes?" in _said(capsys, "expert", "--num_episode=3")


def test_scenes_beyond_the_split_are_refused(idle: None, capsys: pytest.CaptureFixture[str]) -> None:
    said = _said(capsys, "table", "--rows=expert", "--first_seed=99999900", "--num_episodes=25", "--repeats=6")
    assert "got 99999900 to 100000049" in said


def test_a_full_disk_is_told_before_the_work(
    idle: None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("Usage", (), {"free": 1000})())
    for verb, option in (("expert", "output_dir=out"), ("contact-sheet", "output=out.png"), ("demo", "output_dir=out")):
        assert "free space" in _said(capsys, verb, f"--{option}")
