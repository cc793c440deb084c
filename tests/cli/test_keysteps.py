"""``llakey keysteps`` hands on what it is told, and writes over nothing."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from lerobot_llakey.cli import keysteps
from lerobot_llakey.cli.keysteps import KeystepsConfig, run
from lerobot_llakey.datasets.balance import Balance, sampling_mode
from lerobot_llakey.errors import LlakeyError


def test_samples_are_drawn_as_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls: list[Any] = []

    def convert(source: Any, root: Path, repo_id: str, **settings: Any) -> int:
        calls.append((source.name, root, repo_id, settings))
        return 42

    monkeypatch.setattr(keysteps, "open_dataset", lambda name, root: SimpleNamespace(name=name, num_episodes=7))
    monkeypatch.setattr(keysteps, "convert", convert)
    run(KeystepsConfig("me/long", "me/short", output_root=tmp_path / "out", mode="weight", stride=5, seed=3))
    balance = Balance(sampling_mode("weight"), 5, 3, 6)
    assert calls == [("me/long", tmp_path / "out", "me/short", {"balance": balance, "seed": 3})]
    assert f"42 keysteps of 7 episodes: {tmp_path / 'out'}" in capsys.readouterr().out


def test_an_unknown_mode_and_an_occupied_folder_are_refused_before_anything_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keysteps, "open_dataset", lambda *_: pytest.fail("was read"))
    (tmp_path / "file").touch()
    with pytest.raises(LlakeyError, match="thin"):
        run(KeystepsConfig("me/long", "me/short", output_root=tmp_path / "out", mode="other"))
    with pytest.raises(LlakeyError, match="Expected"):
        run(KeystepsConfig("me/long", "me/short", output_root=tmp_path))
