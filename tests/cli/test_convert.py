"""``llakey convert``: from RLBench's folders to a dataset that passes the check and from which keysteps are drawn."""

import json
import pickle
import sys
from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_rlbench import recorded_frames, write_episode
from lerobot_llakey import schema
from lerobot_llakey.cli.main import main


def test_convert_check_keysteps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", list(sys.argv))
    source, out, keysteps = tmp_path / "source", tmp_path / "out", tmp_path / "keysteps"
    frames = recorded_frames("put_groceries_in_cupboard", seed=2, size=64)
    episode = source / "put_groceries_in_cupboard" / "all_variations" / "episodes" / "episode0"
    write_episode(episode, frames)
    options = [f"--source={source}", "--output_repo_id=local/out", f"--output_root={out}", "--num_workers=1"]
    main(["convert", *options])
    assert "1 episodes with 5 keyframes" in capsys.readouterr().out
    main(["check", "--repo_id=local/out", f"--root={out}"])
    assert "0 refused" in capsys.readouterr().out
    drawn = ["--output_repo_id=local/keysteps", f"--output_root={keysteps}"]
    main(["keysteps", "--repo_id=local/out", f"--root={out}", *drawn])
    texts = LeRobotDataset("local/keysteps", root=keysteps).hf_dataset[schema.INSTRUCTION]
    assert "move to the front of the cupboard" in texts
    assert str(tmp_path) not in json.dumps(json.loads((out / "meta" / "llakey_collect.json").read_text()))

    class Harmful:
        def __reduce__(self) -> object:
            return print, ("this must not be printed",)

    (episode / "variation_number.pkl").write_bytes(pickle.dumps(Harmful()))
    with pytest.raises(SystemExit) as ended:
        main(["convert", *options])
    said = capsys.readouterr()
    assert ended.value.code == 1 and "got builtins.print; it is not read" in said.err
    assert "must not" not in said.out


def test_an_unknown_format_is_refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", list(sys.argv))
    with pytest.raises(SystemExit):
        main(["convert", "--format=zarr", "--source=x", "--output_repo_id=a/b"])
    assert "Expected --format out of rlbench, got 'zarr'" in capsys.readouterr().err
