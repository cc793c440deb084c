"""A demonstration in RLBench's layout, recorded once."""

from pathlib import Path

import pytest

from fakes_rlbench import RecordedFrames, recorded_frames, write_episode


@pytest.fixture(scope="session")
def frames() -> RecordedFrames:
    """An opened drawer, seen by two small cameras."""
    return recorded_frames()


@pytest.fixture
def episodes(frames: RecordedFrames, tmp_path: Path) -> Path:
    """A folder of one task with one episode, which a test may damage."""
    write_episode(tmp_path / "source" / "open_drawer" / "all_variations" / "episodes" / "episode0", frames)
    return tmp_path / "source"
