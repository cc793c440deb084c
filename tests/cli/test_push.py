"""llakey push: which options go together, and where they lead."""

import sys
from pathlib import Path

import pytest

from lerobot_llakey.cli import push


def _run(monkeypatch: pytest.MonkeyPatch, *options: str) -> None:
    monkeypatch.setattr(sys, "argv", ["llakey push", *options])
    push.main()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--root=a", "--policy_path=b"], "Expected --root or --policy_path, got both;"),
        (["--root=a", "--results=b"], "Expected --results with --policy_path, got it with a dataset;"),
        (["--root=nowhere"], "Expected the folder of a dataset at nowhere, found none;"),
        (["--policy_path=nowhere"], "Expected a checkpoint folder at nowhere, found none;"),
        (["--privat=true"], "did you mean --private?"),
    ],
)
def test_what_cannot_be_pushed_is_one_sentence(
    options: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        _run(monkeypatch, "--repo_id=me/things", *options)
    assert end.value.code == 1 and message in capsys.readouterr().err


def test_the_options_reach_the_dataset_and_the_policy(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls: list[tuple] = []

    def pushed(*given: object, **options: object) -> tuple[str, bool]:
        calls.append((*given, options))
        return "http://hub/me/things", bool(options["private"])

    monkeypatch.setattr("lerobot_llakey.sharing.push_dataset.push_dataset", pushed)
    monkeypatch.setattr("lerobot_llakey.sharing.push_policy.push_policy", pushed)
    _run(monkeypatch, "--repo_id=me/things", "--root=a", "--private=true", "--license=mit")
    _run(monkeypatch, "--repo_id=me/things", "--policy_path=b", "--results=c.json")
    assert calls == [
        ("me/things", Path("a"), {"private": True, "license": "mit"}),
        ("me/things", Path("b"), Path("c.json"), {"private": None, "license": None}),
    ]
    assert capsys.readouterr().out.splitlines() == [
        "pushed: http://hub/me/things (private)",
        "pushed: http://hub/me/things (public)",
    ]
