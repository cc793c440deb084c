"""``llakey collect`` and ``llakey keysteps`` as typed."""

import sys
from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.cli import collect, keysteps
from lerobot_llakey.cli.collect import CollectConfig


def llakey(verb: object, monkeypatch: pytest.MonkeyPatch, *options: str) -> None:
    monkeypatch.setattr(sys, "argv", ["llakey verb", *options])
    verb.main()  # type: ignore[attr-defined]


def test_demonstrations_are_collected_and_keysteps_drawn_from_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    demonstrations, samples = tmp_path / "demonstrations", tmp_path / "keysteps"
    common = ("--task=open_drawer", "--num_episodes=1", "--repo_id=me/x", "--image_size=32", "--num_workers=1")
    llakey(collect, monkeypatch, *common, f"--root={demonstrations}")
    assert f"demonstrations: {demonstrations}" in capsys.readouterr().out
    outputs = (f"--output_root={samples}", "--output_repo_id=me/y", "--mode=repeat")
    llakey(keysteps, monkeypatch, "--repo_id=me/x", f"--root={demonstrations}", *outputs)
    dataset = LeRobotDataset("me/y", root=samples)
    assert f"{len(dataset)} keysteps of 1 episodes" in capsys.readouterr().out
    texts = dataset.hf_dataset.with_format("numpy")[schema.PREVIOUS_INSTRUCTION]
    assert [str(text) for text in texts].count("") == 6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--task=open_door",), "open_door"),
        (("--num_episodes=0",), "num_episodes"),
        (("--split=exam",), "split"),
        (("--keystep_mode=fat",), "thin, repeat and weight"),
        (("--demonstrations=false",), "--keysteps_root"),
        (("--num_workers=-1",), "--num_workers"),
        (("--num_workers=100000",), "--num_workers"),
        (("--recovery=nan",), "recovery"),
        (("--num_episodes=1000000000000",), "num_episodes"),
        (("--root=/proc/demonstrations",), "/proc"),
    ],
)
def test_bad_options_are_one_sentence_before_any_work(
    options: tuple[str, ...],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    good = {"--task": "open_drawer", "--num_episodes": "1", "--repo_id": "me/x", "--root": str(tmp_path / "root")}
    good |= dict(option.split("=") for option in options)
    with pytest.raises(SystemExit) as exit_info:
        llakey(collect, monkeypatch, *(f"{name}={value}" for name, value in good.items()))
    assert exit_info.value.code == 1
    error = capsys.readouterr().err
    assert error.startswith("error: Expected") and error.count("\n") == 1 and message in error
    assert list(tmp_path.iterdir()) == []


def test_keysteps_beside_demonstrations_get_a_name_of_their_own(tmp_path: Path) -> None:
    config = CollectConfig("open_drawer", 1, "me/x", root=tmp_path / "a", keysteps_root=tmp_path / "b")
    assert config.targets().named() == {
        "demonstrations": (tmp_path / "a", "me/x"),
        "keysteps": (tmp_path / "b", "me/x_keysteps"),
    }
