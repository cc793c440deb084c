"""A dataset of ``put_bulb`` with its skill instructions worded anew."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
from lerobot.datasets.utils import EPISODES_DIR

from lerobot_llakey import schema
from lerobot_llakey.checks.checksums import write_checksums
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments.wordings import trained_wording
from lerobot_llakey.files import replacing

_TASKS = Path("meta/tasks.parquet")


def reworded_copy(source: Path, target: Path, training: str) -> dict[str, str]:
    """Copy a dataset, its skill instructions worded for a training; pictures are shared with the original, not doubled.

    Args:
        source: folder of a finished dataset of put_bulb.
        target: folder of the copy; replaced where it exists.
        training: "one" or "two" wordings.

    Returns:
        The new wording of each old one.

    Raises:
        LlakeyError: if the dataset holds another task, or one wording stands for both sequences of one bulb.
    """
    worded = {text: trained_wording(training, text, sequence) for text, sequence in _sequences(source).items()}
    unfinished = target.with_name(f".{target.name}")
    shutil.rmtree(unfinished, ignore_errors=True)
    shutil.copytree(source, unfinished, copy_function=_link)
    tasks = pd.read_parquet(source / _TASKS)
    tasks.index = pd.Index([worded[str(text)] for text in tasks.index], name=tasks.index.name)
    _replace(unfinished / _TASKS, tasks)
    for path in sorted((unfinished / EPISODES_DIR).rglob("*.parquet")):
        episodes = pd.read_parquet(path)
        episodes["tasks"] = [[worded[str(text)] for text in texts] for texts in episodes["tasks"]]
        _replace(path, episodes)
    write_checksums(unfinished)
    shutil.rmtree(target, ignore_errors=True)
    unfinished.replace(target)
    return worded


def _sequences(root: Path) -> dict[str, int]:
    """The action sequence that each skill instruction of a dataset stands for."""
    texts = pd.read_parquet(root / _TASKS)["task_index"].to_dict()
    names = {index: str(text) for text, index in texts.items()}
    found: dict[str, int] = {}
    for path in sorted((root / "data").rglob("*.parquet")):
        columns = pq.read_table(path, columns=["task_index", schema.EPISODE_SEQUENCE]).to_pandas()
        for index, value in columns.drop_duplicates().itertuples(index=False):
            text, sequence = names[int(index)], int(value)
            if found.setdefault(text, sequence) != sequence:
                raise LlakeyError(f"Expected one sequence for {text!r} in {root}, got two; collect put_bulb anew.")
    return found


def _link(source: str, target: str) -> None:
    """A second name for a file, or a copy where the disk has no such thing."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


def _replace(path: Path, table: pd.DataFrame) -> None:
    with replacing(path) as fresh:
        table.to_parquet(fresh)
