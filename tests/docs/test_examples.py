"""The numbered examples run as their docstrings say, from the repository root, and print what they promise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
