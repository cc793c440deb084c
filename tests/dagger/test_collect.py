"""A dataset of visited states; a run that was stopped goes on, and one that is done does nothing."""

from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_protocol import Hands
from lerobot_llakey import schema
from lerobot_llakey.dagger import collect as module
from lerobot_llakey.dagger.collect import collect
from lerobot_llakey.dagger.plan import DaggerSettings

SETTINGS = DaggerSettings("somewhere", ("open_drawer",), 3, image_size=32, max_steps=5, expert_share=0.0)


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """First episodes of the parts begun. The policy stands still; guided by the expert it acts as the expert."""
    begun: list[int] = []
    real = module._collect_part

    def collect_part(settings: DaggerSettings, task: str, start: int, stop: int, folder: Path) -> int:
        begun.append(start)
        return real(settings, task, start, stop, folder)

    monkeypatch.setattr(module, "_actors", lambda path: (Hands(wrong_hands=True), Hands()))
    monkeypatch.setattr(module, "_collect_part", collect_part)
    monkeypatch.setattr(module, "_PART_EPISODES", 1)
    return begun


def test_every_other_episode_is_guided(tmp_path: Path, parts: list[int]) -> None:
    collect(SETTINGS, tmp_path / "dagger", "local/dagger", num_workers=1)
    dataset = LeRobotDataset("local/dagger", root=tmp_path / "dagger")
    assert dataset.meta.total_episodes == 3 and parts == [0, 1, 2]
    lengths = list(dataset.meta.episodes["length"])
    assert lengths[1] == 3 and lengths[0] == lengths[2] == 5
    first = dataset[0]
    assert first[schema.INSTRUCTION].startswith("move to the front") and first[schema.PREVIOUS_INSTRUCTION] == ""
    seeds = [int(dataset[index][schema.EPISODE_SEED]) for index in (0, 5, 8)]
    assert seeds == [0, 1, 2]


def test_a_stopped_run_goes_on(tmp_path: Path, parts: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    real = module.visited_frames

    def visited_frames(env, actor, scene, rng, expert_share):
        if scene == 2:
            raise KeyboardInterrupt
        return real(env, actor, scene, rng, expert_share)

    monkeypatch.setattr(module, "visited_frames", visited_frames)
    with pytest.raises(KeyboardInterrupt):
        collect(SETTINGS, tmp_path / "dagger", "local/dagger", num_workers=1)
    assert not (tmp_path / "dagger").exists() and len(parts) == 3
    monkeypatch.setattr(module, "visited_frames", real)
    collect(SETTINGS, tmp_path / "dagger", "local/dagger", num_workers=1)
    assert len(parts) == 4  # one part was left
    collect(SETTINGS, tmp_path / "dagger", "local/dagger", num_workers=1)
    assert len(parts) == 4
    assert LeRobotDataset("local/dagger", root=tmp_path / "dagger").meta.total_episodes == 3


def test_another_collection_is_not_mixed_in(tmp_path: Path, parts: list[int]) -> None:
    collect(SETTINGS, tmp_path / "dagger", "local/dagger", num_workers=1)
    other = DaggerSettings("elsewhere", SETTINGS.tasks, 3, image_size=32)
    with pytest.raises(ValueError, match="choose another"):
        collect(other, tmp_path / "dagger", "local/dagger", num_workers=1)
