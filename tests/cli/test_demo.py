"""The demo runs a saved policy, records videos of it, and counts."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lerobot_llakey.cli import demo
from lerobot_llakey.cli.demo import DemoConfig, run


class _Stays:
    """An agent that never moves; what it would do is not the demo's concern."""

    def reset(self, seed: int) -> None:
        pass

    def act(self, env: Any, observation: dict[str, Any]) -> tuple[np.ndarray, str]:
        tool = observation["agent_pos"][:7]
        return np.concatenate((tool, (1.0, 1.0))), "raise the robotic arm"


def test_videos_and_results_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo.Agent, "load", lambda *_: _Stays())
    monkeypatch.setattr(demo, "LlakeySimEnv", _short)
    config = DemoConfig(task="open_drawer", num_episodes=2, num_workers=1, detailed=False, output_dir=tmp_path)
    episodes = run(config)
    assert [episode.seed for episode in episodes] == [0, 1] and not any(episode.success for episode in episodes)
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["episodes"][0]["instructions"] == ["raise the robotic arm"] * 2
    videos = list((tmp_path / "videos").iterdir())
    assert [video.name for video in videos] == ["open_drawer_000_failure.mp4"]
    assert videos[0].stat().st_size > 1000


def test_the_expert_can_be_watched_recovering(tmp_path: Path) -> None:
    config = DemoConfig(
        policy_path="expert",
        task="open_drawer",
        disturbance="empty_grasp",
        num_episodes=1,
        num_videos=0,
        num_workers=1,
        output_dir=tmp_path,
    )
    (episode,) = run(config)
    verbs = [text.split()[0] for text in episode.instructions]
    assert episode.success and verbs[:4] == ["move", "grasp", "move", "grasp"]


def _short(task: str, split: str, **settings: Any) -> Any:
    from lerobot_llakey.sim.env import LlakeySimEnv

    return LlakeySimEnv(task, split, image_size=32, episode_length=2, render_size=(120, 160), **settings)


def test_a_wrong_path_is_told_before_a_process_is_started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo, "run_jobs", lambda *_: pytest.fail("a process was started"))
    with pytest.raises(FileNotFoundError, match="or a Hub name, got /nope, where none was found"):
        run(DemoConfig(policy_path="/nope", task="open_drawer", output_dir=tmp_path / "demo"))
    assert not (tmp_path / "demo").exists()
