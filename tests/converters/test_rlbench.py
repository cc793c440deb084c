"""Whole conversions: the dataset holds what was recorded, a stopped run goes on, and what does not fit is refused."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_rlbench import RecordedFrames
from lerobot_llakey import geometry, schema
from lerobot_llakey.converters import rlbench
from lerobot_llakey.converters.rlbench import PlannedEpisode, convert, plan_episodes
from lerobot_llakey.converters.rlbench_files import find_episodes
from lerobot_llakey.datasets.sequences import SHIPPED, TaskInstructions, read_sequences
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.instructions import BASIC_GRAMMAR

TASKS = read_sequences(SHIPPED, BASIC_GRAMMAR)
UNFIT = {"open_drawer": TaskInstructions("open_drawer", ("{x}",), (("grasp the cup", "release it"),), BASIC_GRAMMAR)}


def planned(source: Path, count: int = 1, cameras: tuple[str, ...] = ()) -> list[PlannedEpisode]:
    first = source / "open_drawer" / "all_variations" / "episodes" / "episode0"
    for number in range(1, count):
        shutil.copytree(first, first.parent / f"episode{number}")
    return plan_episodes(find_episodes(source, (), cameras), TASKS)[0]


def test_keyframes_and_instructions_are_the_experts(episodes: Path, frames: RecordedFrames) -> None:
    (episode,) = planned(episodes)
    assert list(episode.keyframes) == frames.keyframes
    assert list(episode.instructions) == [waypoint.instruction for waypoint in frames.episode.waypoints]
    assert episode.skill == frames.episode.description


def test_the_dataset_holds_what_was_recorded(episodes: Path, frames: RecordedFrames, tmp_path: Path) -> None:
    convert(planned(episodes), tmp_path / "out", "local/out", BASIC_GRAMMAR, num_workers=1)
    dataset = LeRobotDataset("local/out", root=tmp_path / "out")
    assert (len(dataset), dataset.fps) == (len(frames.steps), 20)
    first = frames.keyframes[0]
    item = dataset[first - 1]
    assert item[schema.TASK] == frames.episode.description
    assert item[schema.INSTRUCTION] == frames.episode.waypoints[0].instruction
    reached = frames.episode.states[frames.steps[first]]
    assert np.allclose(item[schema.ACTION][:7], reached[:7], atol=1e-6)
    picture = frames.pictures[first - 1]["wrist"]
    depth = item[schema.depth_key("wrist")].numpy()[0]
    shown = np.rint(picture.depth).clip(10, schema.DEPTH_RANGE_METRES[1] * 1000)
    assert np.abs(depth - shown).max() <= 1, "millimetres"
    placed = item[schema.extrinsics_key("wrist")].numpy()
    assert np.allclose(*map(geometry.pose_to_matrix, (placed, picture.pose)), atol=1e-5)
    assert np.allclose(item[schema.intrinsics_key("wrist")], picture.intrinsics)
    assert item[schema.EPISODE_TASK] == "open_drawer" and int(item[schema.EPISODE_SEED]) == -1


@pytest.mark.slow
def test_a_stopped_run_goes_on_and_a_finished_one_does_nothing(
    episodes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rlbench, "part_size", lambda episodes, workers: 1)
    all_of_it, root, written = planned(episodes, 3, ("front",)), tmp_path / "out", []
    whole = rlbench._convert_part

    def counted(part: list[PlannedEpisode], *rest: object) -> None:
        written.append(part[0].folder.path.name)
        if written == ["episode0", "episode1"]:
            raise KeyboardInterrupt
        whole(part, *rest)

    monkeypatch.setattr(rlbench, "_convert_part", counted)
    with pytest.raises(KeyboardInterrupt):
        convert(all_of_it, root, "local/out", BASIC_GRAMMAR, num_workers=1)
    assert not root.exists()
    convert(all_of_it, root, "local/out", BASIC_GRAMMAR, num_workers=1)
    assert written == ["episode0", "episode1", "episode1", "episode2"]
    assert LeRobotDataset("local/out", root=root).num_episodes == 3 and not root.with_name("out.parts").exists()
    convert(all_of_it, root, "local/out", BASIC_GRAMMAR, num_workers=1)
    assert len(written) == 4
    with pytest.raises(LlakeyError, match="choose another folder"):
        convert(all_of_it[:2], root, "local/out", BASIC_GRAMMAR, num_workers=1)


def test_an_episode_that_fits_no_sequence_is_refused_or_left_out(episodes: Path) -> None:
    folders = find_episodes(episodes)
    with pytest.raises(LlakeyError, match=r"1 of 1 episodes that do not: occ in .*episode0 \(open_drawer: co\)"):
        plan_episodes(folders, UNFIT, skip_unmatched=True)
    other = episodes / "close_jar"
    shutil.copytree(episodes / "open_drawer", other)
    both = find_episodes(episodes)
    tasks = {"open_drawer": TASKS["open_drawer"], "close_jar": UNFIT["open_drawer"]}
    with pytest.raises(LlakeyError, match="leave them out with --skip_unmatched=true"):
        plan_episodes(both, tasks)
    kept, left_out = plan_episodes(both, tasks, skip_unmatched=True)
    assert [one.folder.task for one in kept] == ["open_drawer"] and [path.parents[2].name for path in left_out] == [
        "close_jar"
    ]
    with pytest.raises(LlakeyError, match=r"got close_jar; add them in a file for --instructions"):
        plan_episodes(both, {"open_drawer": TASKS["open_drawer"]})
