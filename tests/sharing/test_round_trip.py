"""Over loopback: a dataset is pushed and trained on by its name; the policy made of it is pushed and evaluated."""

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hub_server import Hub, hub_server

BIN = Path(sys.executable).parent
TASKS = "open_drawer,close_jar"
TINY_ACTION = {
    **{"widths": "[16,24,32]", "blocks": "[1,1]", "transformer_layers": 1, "transformer_heads": 2, "view_size": 64},
    **{"text_width": 32, "text_layers": 1},
}
TINY_COMMAND = {
    **{"vision_width": 32, "vision_layers": 1, "vision_heads": 2, "text_width": 32, "text_layers": 1, "text_heads": 2},
    **{"image_size": 32},
}
PULL = """
import sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
dataset = LeRobotDataset(sys.argv[1])
print("pulled", dataset.root, dataset.num_episodes, len(dataset), dataset[0]["instruction"])
"""
Run = Callable[..., str]


@pytest.fixture
def served() -> Iterator[Hub]:
    with hub_server() as hub:
        yield hub


@pytest.fixture
def run(served: Hub, tmp_path: Path) -> Run:
    """Runs a command in a process that knows the server on loopback alone, with caches of its own."""
    offline = ("HF_HUB_OFFLINE", "TRANSFORMERS_OFFLINE")
    own = {
        **{
            "HF_ENDPOINT": served.url,
            "HF_HUB_DISABLE_XET": "1",
            "HF_TOKEN": "hf_test",
            "HF_HOME": str(tmp_path / "hf"),
        },
        **{"HF_LEROBOT_HOME": str(tmp_path / "lerobot"), "NO_PROXY": "127.0.0.1"},
        **{"PYTHONPATH": str(Path(__file__).parents[2])},
    }
    environment = {name: value for name, value in os.environ.items() if name not in offline} | own

    def call(*command: str) -> str:
        done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=900)
        assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
        return done.stdout

    return call


def llakey(verb: str, *options: str) -> tuple[str, ...]:
    return (sys.executable, "-m", "lerobot_llakey.cli.main", verb, *options)


def flags(prefix: str, settings: dict) -> list[str]:
    return [f"--{prefix}.{name}={value}" for name, value in settings.items()]


def hashes(root: Path) -> dict[str, str]:
    """SHA-256 of each file of a dataset."""
    parts = [file for part in ("data", "meta", "videos") for file in (root / part).rglob("*") if file.is_file()]
    return {str(file.relative_to(root)): hashlib.sha256(file.read_bytes()).hexdigest() for file in parts}


def collect(run: Run, tasks: str, root: Path) -> None:
    run(
        *llakey("collect", f"--task={tasks}", "--num_episodes=1", "--repo_id=me/keysteps", "--demonstrations=false"),
        *(f"--keysteps_root={root}", "--image_size=32", "--num_workers=1"),
    )


def push_and_pull(run: Run, root: Path, episodes: int) -> None:
    """Push a dataset, pull it by its name, and hold one against the other."""
    assert "/datasets/me/keysteps (public)" in run(*llakey("push", "--repo_id=me/keysteps", f"--root={root}"))
    _, pulled, count, frames, _ = run(sys.executable, "-c", PULL, "me/keysteps").splitlines()[-1].split(maxsplit=4)
    assert int(count) == episodes and hashes(Path(pulled)) == hashes(root)
    print(f"{count} episodes, {frames} frames, {len(hashes(root))} files with the same SHA-256")


@pytest.mark.slow
def test_from_a_dataset_to_an_evaluated_policy_by_names_alone(run: Run, served: Hub, tmp_path: Path) -> None:
    collect(run, TASKS, tmp_path / "keysteps")
    push_and_pull(run, tmp_path / "keysteps", episodes=2)
    run(
        *(str(BIN / "lerobot-train"), "--policy.type=llakey", "--policy.device=cpu", "--policy.push_to_hub=false"),
        *("--dataset.repo_id=me/keysteps", f"--output_dir={tmp_path / 'trained'}"),
        *("--batch_size=2", "--steps=2", "--num_workers=0"),
        *(*flags("policy.action", TINY_ACTION), *flags("policy.command", TINY_COMMAND)),
    )
    checkpoint = tmp_path / "trained/checkpoints/last/pretrained_model"
    pushed = run(*llakey("push", "--repo_id=me/llakey", f"--policy_path={checkpoint}"))
    assert f"pushed: {served.url}/me/llakey (private)" in pushed
    card = served.repos["models", "me/llakey"].head["README.md"][0].decode()
    assert "| trained on | me/keysteps |" in card and "2 of 2" in card
    run(
        *(str(BIN / "lerobot-eval"), "--policy.path=me/llakey", "--policy.device=cpu", "--env.type=llakey_sim"),
        *("--env.task=open_drawer", "--eval.n_episodes=1", "--eval.batch_size=1", "--eval.use_async_envs=false"),
        *("--env.episode_length=1", "--env.image_size=32", f"--output_dir={tmp_path / 'eval'}"),
    )
    results, sent = f"--results={tmp_path / 'eval/eval_info.json'}", len(served.uploads)
    run(*llakey("push", "--repo_id=me/llakey", f"--policy_path={checkpoint}", results))
    assert "| overall | 1 | " in served.repos["models", "me/llakey"].head["README.md"][0].decode()
    assert len(served.uploads) == sent


@pytest.mark.slow
def test_nine_tasks_are_pushed_and_pulled_without_a_difference(run: Run, tmp_path: Path) -> None:
    collect(run, "all", tmp_path / "keysteps")
    push_and_pull(run, tmp_path / "keysteps", episodes=9)
