"""The layout on disk: what is found, in which order, and what is missing or broken."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fakes_rlbench import FAR, NEAR, RecordedFrames, write_episode
from lerobot_llakey.converters.rlbench_files import EpisodeFolder, find_episodes
from lerobot_llakey.errors import LlakeyError


def only(source: Path) -> EpisodeFolder:
    (episode,) = find_episodes(source)
    return episode


def test_what_was_written_is_read(episodes: Path, frames: RecordedFrames) -> None:
    episode = only(episodes)
    assert episode.task == "open_drawer" and episode.cameras == ("front", "wrist")
    assert episode.skills() == [frames.episode.description] and episode.variation() == frames.episode.variation
    assert len(episode.observations()) == len(frames.steps)
    seen = frames.pictures[5]["front"]
    assert np.array_equal(episode.colours("front", 5), seen.rgb)
    metres = episode.depth("front", 5, NEAR, FAR)
    assert np.abs(metres * 1000 - seen.depth.clip(NEAR * 1000, FAR * 1000)).max() < 0.001
    assert find_episodes(episodes / "open_drawer") == [episode], "one task's folder will do"


def test_episodes_come_by_variation_and_number(episodes: Path) -> None:
    original = only(episodes).path
    shutil.copytree(original, original.parent / "episode10")
    shutil.copytree(original, original.parent / "episode9")
    assert [one.path.name for one in find_episodes(episodes)] == ["episode0", "episode9", "episode10"]


def test_rlbenchs_own_layout_by_variations_is_read(episodes: Path) -> None:
    task = episodes / "open_drawer"
    (task / "all_variations").rename(task / "variation7")
    path = task / "variation7" / "episodes" / "episode0"
    (path / "variation_descriptions.pkl").rename(task / "variation7" / "variation_descriptions.pkl")
    (path / "variation_number.pkl").unlink()
    episode = only(episodes)
    assert episode.variation() == 7 and episode.skills()


def test_some_tasks_and_cameras(episodes: Path) -> None:
    assert find_episodes(episodes, ["open_drawer"], ["wrist"])[0].cameras == ("wrist",)
    with pytest.raises(LlakeyError, match=r"tasks close_jar in .* got open_drawer"):
        find_episodes(episodes, ["close_jar"])
    with pytest.raises(LlakeyError, match=r"depth of overhead in .* got those of front, wrist"):
        find_episodes(episodes, (), ["overhead"])


def _remove(name: str) -> Callable[[Path], None]:
    return lambda path: (path / name).unlink()


def _cut(name: str) -> Callable[[Path], None]:
    def cut(path: Path) -> None:
        content = (path / name).read_bytes()
        (path / name).write_bytes(content[: len(content) // 2])

    return cut


def _grey(path: Path) -> None:
    Image.new("L", (32, 32)).save(path / "wrist_depth" / "4.png")


@pytest.mark.parametrize(
    ("damage", "match"),
    [
        (_remove("low_dim_obs.pkl"), r"low_dim_obs\.pkl, found none"),
        (_cut("low_dim_obs.pkl"), r"whole pickle at .*low_dim_obs\.pkl"),
        (_remove("variation_descriptions.pkl"), r"variation_descriptions\.pkl"),
        (_remove("variation_number.pkl"), r"variation_number\.pkl"),
        (_remove("front_rgb/3.png"), r"front_rgb.* \(3\.png is missing\)"),
        (_cut("front_rgb/4.png"), r"PNG picture at .*4\.png"),
        (_cut("wrist_depth/4.png"), r"PNG picture at .*4\.png"),
        (_grey, r"4\.png in red, green and blue"),
    ],
)
def test_what_is_missing_or_cut_is_named(episodes: Path, damage: Callable[[Path], None], match: str) -> None:
    episode = only(episodes)
    damage(episode.path)
    with pytest.raises(LlakeyError, match=match):
        _ = episode.observations(), episode.skills(), episode.variation()
        for step in (3, 4):
            _ = episode.colours("front", step), episode.depth("wrist", step, NEAR, FAR)


def test_a_picture_too_many_is_told(episodes: Path) -> None:
    episode = only(episodes)
    (episode.path / "front_depth" / "999.png").touch()
    with pytest.raises(LlakeyError, match=r"999\.png is one too many"):
        episode.observations()


def test_nothing_there_is_told(tmp_path: Path, frames: RecordedFrames) -> None:
    with pytest.raises(LlakeyError, match="found no episode"):
        find_episodes(tmp_path)
    with pytest.raises(LlakeyError, match="check --source"):
        find_episodes(tmp_path / "none")
    for number in range(2):
        write_episode(tmp_path / "t" / "all_variations" / "episodes" / f"episode{number}", frames)
    shutil.rmtree(tmp_path / "t" / "all_variations" / "episodes" / "episode1" / "wrist_rgb")
    with pytest.raises(LlakeyError, match=r"same cameras \(front, wrist\)"):
        find_episodes(tmp_path)
