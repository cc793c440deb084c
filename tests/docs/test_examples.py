"""The numbered examples run as their docstrings say, from the repository root, and print what they promise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lerobot_llakey.datasets.collect_record import read_record

ROOT = Path(__file__).parents[2]
EXAMPLES = {
    "01_policy_on_one_observation": ["observation.images.front", "next instruction: move to the", "gripper is open"],
    "02_own_task": ["block -> raise the robotic arm, solved: True"],
    "03_own_grammar": ["'grasp the cup' is refused: Expected", "this policy does: 'come up'"],
    "04_own_camera_rig": ["side and top", "'gripper_open'"],
    "05_own_commander": ["grasp the", "drawer: done"],
}


def test_every_example_is_run_and_says_how() -> None:
    files = sorted((ROOT / "docs" / "examples").glob("*.py"))
    assert [file.stem for file in files] == sorted(EXAMPLES)
    for file in files:
        lines = file.read_text().splitlines()
        assert f"python docs/examples/{file.name}" in "\n".join(lines[:8])
        assert 20 <= len(lines) <= 60


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_runs(example: str) -> None:
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, f"docs/examples/{example}.py"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert not [text for text in EXAMPLES[example] if text not in done.stdout], done.stdout


@pytest.mark.slow
def test_the_slurm_array_collects_shards(tmp_path: Path) -> None:
    llakey = tmp_path / "bin" / "llakey"
    llakey.parent.mkdir()
    llakey.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m lerobot_llakey.cli.main "$@"\n')
    llakey.chmod(0o755)
    paths = {"PATH": f"{llakey.parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    array = {"SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_MIN": "0", "SLURM_ARRAY_TASK_COUNT": "2"}
    options = ("--task=open_drawer", "--num_episodes=2", "--image_size=32")
    done = subprocess.run(
        ["bash", "docs/examples/slurm_collect.sh", str(tmp_path / "demos"), *options],
        cwd=ROOT,
        env=os.environ | paths | array | {"SLURM_CPUS_PER_TASK": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    record = read_record(tmp_path / "demos.shards" / "2")
    assert record["episodes"] == 1
    assert record["settings"]["shard"] == {"number": 2, "count": 2, "episodes": 2}
