"""Datasets with their skill instructions worded anew load as before, with the new words."""

from pathlib import Path

import pandas as pd
import pyarrow as pa
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.checks.checksums import write_checksums
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.experiments.rewording import reworded_copy
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED


@pytest.fixture
def bulbs(tmp_path: Path) -> Path:
    """Made-up keysteps as if of put_bulb: red and yellow are screwed in."""
    root = tmp_path / "bulbs"
    fake_keysteps(root, episodes=6)
    path = root / "meta/tasks.parquet"
    tasks = pd.read_parquet(path)
    colours = [str(text).split()[3] for text in tasks.index]
    tasks.index = pd.Index([f"put the {colour} light bulb in the purple box" for colour in colours], name="task")
    tasks.to_parquet(path)
    kinds = [SCREWED if colour in ("red", "yellow") else LOOSE for colour in colours]
    assert set(kinds) == {LOOSE, SCREWED}

    def sequence(table: pa.Table) -> dict[str, pa.Array]:
        return {schema.EPISODE_SEQUENCE: pa.array([kinds[index] for index in table["task_index"].to_pylist()])}

    rewrite(root, sequence, {schema.EPISODE_SEQUENCE: {"dtype": "int64", "shape": (1,), "names": None}})
    for file in (root / "meta/episodes").rglob("*.parquet"):
        episodes = pd.read_parquet(file)
        episodes["tasks"] = [
            [f"put the {texts[0].split()[3]} light bulb in the purple box"] for texts in episodes["tasks"]
        ]
        episodes.to_parquet(file)
    write_checksums(root)
    return root


def test_two_wordings_reach_the_loader(bulbs: Path, tmp_path: Path) -> None:
    reworded_copy(bulbs, tmp_path / "two", "two")
    before, after = LeRobotDataset("a/b", root=bulbs), LeRobotDataset("a/c", root=tmp_path / "two")
    assert len(before) == len(after)
    for index in range(0, len(after), 6):
        old, new = before[index], after[index]
        screwed = old["task"].split()[2] in ("red", "yellow")
        assert new["task"].startswith("unscrew" if screwed else "put")
        assert new["task"] == old["task"] or screwed
        assert (new[schema.STATE] == old[schema.STATE]).all() and new[schema.INSTRUCTION] == old[schema.INSTRUCTION]


def test_the_original_keeps_its_words(bulbs: Path, tmp_path: Path) -> None:
    reworded_copy(bulbs, tmp_path / "two", "two")
    reworded_copy(bulbs, tmp_path / "two", "two")  # again, as after a run that was ended
    assert all(str(text).startswith("put the") for text in LeRobotDataset("a/b", root=bulbs).meta.tasks.index)


def test_a_wording_of_two_sequences_is_refused(bulbs: Path, tmp_path: Path) -> None:
    def mixed(table: pa.Table) -> dict[str, pa.Array]:
        return {schema.EPISODE_SEQUENCE: pa.array([index % 2 for index in range(len(table))])}

    rewrite(bulbs, mixed, {schema.EPISODE_SEQUENCE: {"dtype": "int64", "shape": (1,), "names": None}})
    with pytest.raises(ValueError, match="Expected one sequence"):
        reworded_copy(bulbs, tmp_path / "two", "two")
