"""A dataset that names other files than its own is refused before one of them is read."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lerobot_llakey import schema
from lerobot_llakey.checks.foreign_files import refuse_paths_outside
from lerobot_llakey.errors import LlakeyError, MissingFileError


@pytest.fixture
def root(sound: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(sound, tmp_path / "copy"))


def describe(root: Path, **changes: object) -> None:
    path = root / "meta" / "info.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def put_cells(root: Path, key: str, cells: list[object], kind: pa.DataType) -> None:
    """Let a column end with some cells and begin with the first of them."""
    path = next((root / "data").rglob("*.parquet"))
    table = pq.read_table(path)
    column = pa.array([cells[0]] * (table.num_rows - len(cells)) + cells, kind)
    pq.write_table(table.set_column(table.column_names.index(key), key, column), path)


def test_a_dataset_of_its_own_files_passes(sound: Path) -> None:
    refuse_paths_outside(sound)


@pytest.mark.parametrize("entry", ["data_path", "video_path"])
@pytest.mark.parametrize(
    "template",
    [
        "../secret/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "data/../../secret.parquet",
        "/etc/secret.parquet",
        "C:\\secret\\file.parquet",
        "data\\..\\..\\secret.parquet",
        "data/{chunk_index.__class__}/file.parquet",
        "data/{secret}/file.parquet",
        "data/{chunk_index:99999999999d}",
        ["data"],
    ],
)
def test_a_template_that_leads_outside_is_refused(root: Path, entry: str, template: object) -> None:
    describe(root, **{entry: template})
    with pytest.raises(LlakeyError, match=entry):
        refuse_paths_outside(root)


def test_a_column_whose_name_is_a_path_is_refused(root: Path) -> None:
    features = json.loads((root / "meta" / "info.json").read_text())["features"]
    describe(root, features=features | {"../../secret": {"dtype": "video", "shape": [1], "names": None}})
    with pytest.raises(LlakeyError, match="secret"):
        refuse_paths_outside(root)


def test_a_text_for_a_chunks_number_is_refused(root: Path) -> None:
    path = next((root / "meta" / "episodes").rglob("*.parquet"))
    table = pq.read_table(path)
    place = table.column_names.index("data/chunk_index")
    texts = pa.array(["../../secret"] * table.num_rows)
    pq.write_table(table.set_column(place, "data/chunk_index", texts), path)
    with pytest.raises(LlakeyError, match="data/chunk_index"):
        refuse_paths_outside(root)


@pytest.mark.parametrize("name", ["/any/file.png", "../secret.png", "https://example.org/a.png", "secret.png"])
def test_a_cell_that_names_a_file_is_refused(root: Path, name: str) -> None:
    key = schema.image_key("front")
    kind = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
    put_cells(root, key, [{"bytes": b"png", "path": None}, {"bytes": None, "path": name}], kind)
    with pytest.raises(LlakeyError, match=f"{key}.*names the file"):
        refuse_paths_outside(root)


def test_a_column_of_paths_is_refused(root: Path) -> None:
    key = schema.depth_key("wrist")
    put_cells(root, key, ["/any/file.png", "/any/other.png"], pa.string())
    with pytest.raises(LlakeyError, match=key):
        refuse_paths_outside(root)


def test_a_path_beside_an_embedded_picture_does_no_harm(root: Path) -> None:
    kind = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
    put_cells(root, schema.image_key("front"), [{"bytes": b"png", "path": "/where/it/was.png"}], kind)
    refuse_paths_outside(root)


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/no/where")], ids=["pipe", "dangling link"])
def test_what_is_no_file_is_refused(root: Path, make: Callable[[Path], None]) -> None:
    path = next((root / "data").rglob("*.parquet"))
    path.unlink()
    make(path)
    with pytest.raises(LlakeyError, match=path.name):
        refuse_paths_outside(root)


def test_what_is_no_dataset_is_said(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"info\.json"):
        refuse_paths_outside(tmp_path)
    (tmp_path / "meta").mkdir()
    for content in ("[]", '{"features": 3}', "{"):
        (tmp_path / "meta" / "info.json").write_text(content)
        with pytest.raises(LlakeyError, match=r"info\.json"):
            refuse_paths_outside(tmp_path)
