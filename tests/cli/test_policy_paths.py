"""Every verb that takes a policy says in one sentence that there is none, before it does anything else."""

import sys
from importlib import import_module

import pytest

from lerobot_llakey.cli.main import VERBS

REST = {
    "abilities": ["--repo_id=l/x"],
    "keyframe-accuracy": ["--repo_id=l/x"],
    "show": ["--repo_id=l/x"],
    "dagger": ["--task=open_drawer", "--num_episodes=1"],
    "demo": ["--task=open_drawer"],
    "drive": ["--terminal"],
    "compose": ["--split=true"],
    "table": ["--task=open_drawer"],
    "rollback": ["--task=open_drawer"],
}


@pytest.mark.parametrize("verb", REST)
def test_a_wrong_path_is_one_sentence(
    verb: str, tmp_path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = "--rows=/nope" if verb in ("table", "rollback") else "--policy_path=/nope"
    place = "--root=out" if verb == "dagger" else "--output=out.png" if verb == "show" else "--output_dir=out"
    monkeypatch.setattr(sys, "argv", [f"llakey {verb}", path, place, *REST[verb]])
    with pytest.raises(SystemExit) as end:
        import_module(VERBS[verb][0]).main()
    assert end.value.code == 1
    told = capsys.readouterr().err.strip().splitlines()[-1]
    assert told.startswith("error: Expected ") and "/nope" in told and "offline" not in told
    assert not list(tmp_path.iterdir())
