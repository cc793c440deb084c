"""Columns are read file by file, and their rows are named as a person counts them."""

from pathlib import Path

import numpy as np
import pytest

from fakes_wrong import read_rows, write_rows
from lerobot_llakey import schema
from lerobot_llakey.checks.columns import EPISODE, FRAME, Columns, read_columns
from lerobot_llakey.checks.finding import Place
from lerobot_llakey.errors import LlakeyError

STATE = {schema.STATE: schema.vector(schema.SIM_STATE_NAMES)}


def test_hand_and_joints_are_found_by_their_names(sound: Path) -> None:
    [columns] = read_columns(sound, STATE)
    assert columns.hand is not None and columns.joints is not None
    assert np.array_equal(columns.hand, columns[schema.STATE][:, :8])
    assert np.array_equal(columns.joints, columns[schema.STATE][:, 8:])


def test_a_column_of_another_shape_is_odd(sound: Path) -> None:
    [columns] = read_columns(sound, {schema.STATE: schema.vector(["x", "y"]) | {"shape": (7,)}})
    assert schema.STATE in columns.odd and schema.STATE not in columns


def test_a_row_is_named_by_episode_and_frame() -> None:
    columns = Columns({EPISODE: np.array([0, 0, 4, 4]), FRAME: np.array([0, 1, 0, 1])}, {})
    assert columns.place(np.array([False, False, True, True])) == Place("episode 4, frame 0 (and 1 more rows)", 4, 0)
    assert Columns({"x": np.zeros(3)}, {}).place(np.array([False, True, False])) == Place("row 1")
    assert columns.episodes() == [slice(0, 2), slice(2, 4)]


def test_what_is_not_finite_is_seen() -> None:
    columns = Columns({"x": np.array([0.0, np.nan]), "y": np.zeros(2)}, {})
    assert columns.is_finite("y", "not there") and not columns.is_finite("y", "x")


def test_a_file_that_is_none_is_refused(sound: Path, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "a.parquet").write_bytes(b"PAR1")
    with pytest.raises(LlakeyError, match="parquet file"):
        list(read_columns(tmp_path, STATE))


def test_of_many_rows_files_at_equal_distances_are_read(sound: Path, tmp_path: Path) -> None:
    import shutil

    shutil.copytree(sound, tmp_path / "many")
    [file] = (tmp_path / "many" / "data").rglob("*.parquet")
    rows = read_rows(tmp_path / "many")
    write_rows(tmp_path / "many", rows)
    for number in range(1, 6):
        shutil.copy(file, file.with_name(f"file-{number:03d}.parquet"))
    assert len(list(read_columns(tmp_path / "many", STATE, most=3 * len(rows[EPISODE])))) == 3
