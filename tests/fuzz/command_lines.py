"""Options of every verb that make no sense, and places that cannot be written to."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from fuzz.case import Case

_HUGE = "1000000000000"
_NEEDED: dict[str, tuple[str, ...]] = {
    "collect": ("--task=open_drawer", "--num_episodes=1", "--repo_id=l/x", "--root=out", "--num_workers=1"),
    "annotate": ("--repo_id=l/x", "--root=none"),
    "keysteps": ("--repo_id=l/x", "--root=none", "--output_repo_id=l/y", "--output_root=out"),
    "dagger": ("--policy_path=checkpoints/none", "--task=open_drawer", "--num_episodes=1", "--root=out"),
    "merge": ("--roots=a,b", "--root=out"),
    "compose": ("--output_dir=out",),
    "bench": ("--part=render",),
    "abilities": ("--policy_path=none", "--repo_id=l/x", "--root=none"),
    "keyframe-accuracy": ("--policy_path=none", "--repo_id=l/x", "--root=none"),
    "show": ("--policy_path=none", "--repo_id=l/x", "--root=none"),
    "table": ("--rows=none.yaml",),
    "rollback": ("--rows=none.yaml",),
    "ambiguity": (),
    "reproduce": (),
    "expert": ("--task=open_drawer", "--num_episodes=1", "--num_workers=1"),
    "contact-sheet": ("--output=out.png", "--task=open_drawer"),
    "stress": ("--task=open_drawer", "--num_actions=1", "--num_workers=1"),
    "determinism": ("--task=open_drawer",),
    "demo": ("--policy_path=expert", "--task=open_drawer", "--num_episodes=1", "--num_videos=0", "--output_dir=out"),
    "drive": ("--policy_path=none", "--terminal=true"),
    "check": ("--repo_id=l/x", "--root=none"),
}
"""Verbs with what they need; another value of an option takes its place."""
_WRONG: dict[str, tuple[str, ...]] = {
    "num_episodes": ("0", "-1", _HUGE, "nan", "two"),
    "num_workers": ("-1", "-1000", "1000000", "1.5"),
    "seed": ("-1", _HUGE, "x"),
    "first_seed": ("-1", _HUGE),
    "split": ("trial", ""),
    "task": ("", ",", "no_such", "open_drawer,open_drawer"),
    "image_size": ("0", "1", "-5", "100000"),
    "fps": ("0", "-10", "nan"),
    "recovery": ("nan", "-0.1", "1.5", "inf"),
    "execution_noise": ("nan", "-0.1", "2"),
    "expert_share": ("nan", "-1", "2"),
    "max_steps": ("0", "-1"),
    "batch_size": ("0", "-4"),
    "steps": ("0", "-1"),
    "shard": ("0/4", "5/4", "3", "-1/4", "1/0", "a/b", "", "1/1000000"),
    "engine": ("spark", ""),
    "num_actions": ("-1", "0", "x"),
    "actions": ("-1", "1000000"),
    "num_videos": ("-1",),
    "index": ("-1", _HUGE),
    "max_samples": ("0", "-3"),
    "port": ("-1", "99999", "http"),
    "pause_seconds": ("nan", "-1", "inf"),
    "disturbance": ("earthquake",),
    "events": ("earthquake", ","),
    "keystep_stride": ("0", "-1"),
    "stride": ("0", "-1"),
    "min_per_segment": ("-1",),
    "keyframe_repeats": ("-1", "0"),
    "keystep_mode": ("fat",),
    "mode": ("fat",),
    "arm_tolerance": ("nan", "0", "-1", "inf"),
    "gripper_tolerance": ("nan", "-1"),
    "min_rest": ("nan", "-1", "inf"),
    "part": ("all", ""),
    "device": ("abacus",),
    "repeats": ("0", "-2"),
    "root": ("FILE", "FILE/under", "/proc/llakey", "DANGLING", "FILLED"),
    "keysteps_root": ("FILE", "out", "out/inside", "/proc/llakey", "DANGLING"),
    "output_root": ("FILE", "/proc/llakey", "FILLED"),
    "output_dir": ("FILE", "FILE/under", "/proc/llakey", "DANGLING/under"),
    "output": ("FILE/under.png", "/proc/llakey.png", "FILLED"),
    "policy_path": ("/no/where", "none", "FILE", "FILLED", ""),
    "rows": ("none.yaml", "FILE", "FILLED", "/no/where"),
    "command_path": ("/no/where", "FILE"),
    "action_path": ("/no/where", "FILE"),
    "abilities_root": ("/no/where", "FILE"),
    "roots": ("", "/no/where", "FILE,FILE", "FILLED,FILLED"),
    "instructions": ("/no/where", "FILE", "FILLED"),
    "no_such_option": ("1",),
}
"""Options with values that are wrong for every verb. FILE, DANGLING and FILLED are made in the scratch folder."""


def _run(verb: str, options: tuple[str, ...], folder: Path) -> None:
    from lerobot_llakey.cli.main import main

    (folder / "FILE").write_text("text")
    (folder / "DANGLING").symlink_to(folder / "no" / "where")
    (folder / "FILLED").mkdir()
    (folder / "FILLED" / "mine.txt").write_text("keep me")
    try:
        main([verb, *options])
    finally:
        assert (folder / "FILLED" / "mine.txt").read_text() == "keep me", "a person's file was removed"
        assert (folder / "FILE").read_text() == "text", "a person's file was overwritten"


def _options(verb: str) -> set[str]:
    """Names of a verb's options."""
    import dataclasses
    import importlib
    import inspect

    from lerobot_llakey.cli.main import VERBS

    module = importlib.import_module(VERBS[verb][0])
    classes = [
        kind for _, kind in inspect.getmembers(module, dataclasses.is_dataclass) if kind.__module__ == module.__name__
    ]
    return {field.name for kind in classes for field in dataclasses.fields(kind)}


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Every verb with every option that it has, wrong in turn; one at a time."""
    for verb, needed in _NEEDED.items():
        known = _options(verb)
        for option, values in _WRONG.items():
            if option not in known and option != "no_such_option":
                continue
            for value in values:
                others = tuple(text for text in needed if not text.startswith(f"--{option}="))
                if verb == "collect" and option == "root":
                    others = (*others, "--demonstrations=true")
                yield Case(
                    "command line", f"{verb} --{option}={value}", partial(_run, verb, (*others, f"--{option}={value}"))
                )
    for verb in _NEEDED:
        yield Case("command line", f"{verb} --", partial(_run, verb, ("--",)))
