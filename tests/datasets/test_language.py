"""Instructions as LeRobot's own language rows."""

from pathlib import Path

import pytest
from lerobot.datasets.language import LANGUAGE_PERSISTENT
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.datasets.language import write_language


def test_each_segment_begins_with_its_instruction(tmp_path: Path) -> None:
    source = fake_keysteps(tmp_path / "data", episodes=2, frames=6)
    write_language(tmp_path / "data")
    dataset = LeRobotDataset(source.repo_id, root=tmp_path / "data")
    for episode in range(2):
        frames = [frame for frame in dataset if int(frame["episode_index"]) == episode]
        expected: dict[int, tuple[str, float]] = {}
        for frame in frames:
            begun = (frame[schema.INSTRUCTION], round(float(frame["timestamp"]), 4))
            expected.setdefault(int(frame[schema.KEYFRAME_INDEX]), begun)
        for frame in frames:
            rows = frame[LANGUAGE_PERSISTENT]
            assert [(row["content"], round(row["timestamp"], 4)) for row in rows] == list(expected.values())
            assert {row["style"] for row in rows} == {"subtask"}


def test_a_dataset_without_instructions_is_refused(tmp_path: Path) -> None:
    fake_keysteps(tmp_path / "data", episodes=1, frames=2, without=(schema.INSTRUCTION,))
    with pytest.raises(ValueError, match="Expected the column"):
        write_language(tmp_path / "data")
