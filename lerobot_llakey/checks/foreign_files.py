"""A dataset comes from strangers: it may name no file but its own."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from string import Formatter
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from lerobot.datasets.utils import EPISODES_DIR, INFO_PATH

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading

_FIELDS = {"chunk_index", "file_index", "video_key", "episode_chunk", "episode_index"}
"""What LeRobot fills into the templates of a dataset's paths."""
_PICTURE_TYPES = ("image", "video")
_EMBEDDED = re.compile(r"frame[-_]\d+\.(png|jpe?g|tiff?)")
"""Names that LeRobot leaves beside pictures that it has embedded."""


def refuse_paths_outside(root: Path, info: Mapping[str, Any] | None = None) -> None:
    """Refuse a dataset that would have files read or written outside its own folder.

    LeRobot fills the templates ``data_path`` and ``video_path`` of ``info.json``, and the datasets library opens the
    file or address that a picture's cell names where the cell holds no picture. Both come from whoever made the
    dataset: with them a stranger's dataset reads local pictures, which a merged and pushed dataset then shows. Call it
    before anything else of the dataset is read.

    Args:
        root: folder of the dataset.
        info: what its ``info.json`` says, read from there where it is not given.

    Raises:
        MissingFileError: if there is no dataset.
        LlakeyError: naming the entry, the file and the row where a path leads outside, or what is no file.
    """
    for folder in ("meta", "data"):
        for path in sorted((root / folder).rglob("*")):
            if not path.is_file() and not path.is_dir():
                raise LlakeyError(
                    f"Expected files and folders in {root}, got {path.relative_to(root)}, which is a pipe, a device "
                    "or a link to nothing; fetch or make the dataset anew."
                )
    if info is None:
        with reading(root / INFO_PATH, "description of a dataset"):
            info = json.loads((root / INFO_PATH).read_text(encoding="utf-8"))
        if not isinstance(info, Mapping) or not isinstance(info.get("features"), Mapping):
            raise LlakeyError(
                f"Expected the description of a dataset with features in {root / INFO_PATH}, got another JSON file; "
                "fetch or make the dataset anew."
            )
    features = info["features"]
    for name in features:
        if not _stays_inside(str(name)):
            raise LlakeyError(f"Expected names of columns in {root}, got {name!r}, which is a path; rename the column.")
    for entry in ("data_path", "video_path"):
        if info.get(entry) is not None:
            _check_template(root, entry, info[entry], features)
    for path in sorted((root / EPISODES_DIR).rglob("*.parquet")):
        _check_numbers(path)
    pictures = [key for key, feature in features.items() if feature.get("dtype") in _PICTURE_TYPES]
    for path in sorted((root / "data").rglob("*.parquet")):
        _check_pictures(path, pictures)


def _stays_inside(path: str) -> bool:
    """Whether a relative path leads nowhere but down, on any system."""
    forms = PurePosixPath(path), PureWindowsPath(path)
    return not any(form.is_absolute() or form.drive or form.root or ".." in form.parts for form in forms)


def _check_template(root: Path, entry: str, template: Any, features: Iterable[str]) -> None:
    try:
        parsed = [part for part in Formatter().parse(template) if part[1] is not None]
        # A width of a billion would fill the memory.
        fields = {field if re.fullmatch(r"(0?\d)?d?", spec or "") else "?" for _, field, spec, _ in parsed}
        filled = [
            template.format(chunk_index=0, file_index=0, video_key=key, episode_chunk=0, episode_index=0)
            for key in ("video", *features)
            if fields <= _FIELDS
        ]
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        fields, filled = {"?"}, []
    if not fields <= _FIELDS or not all(map(_stays_inside, filled)):
        raise LlakeyError(
            f"Expected {entry} in {root / INFO_PATH} to stay inside the dataset's folder, got {str(template)[:200]!r}; "
            "do not use this dataset, or correct the entry."
        )


def _check_numbers(path: Path) -> None:
    """The numbers that are filled into the templates are numbers: a text there could be a path."""
    with reading(path, "parquet file"):
        schema = pq.read_schema(path)
    for field in schema:
        if field.name.endswith(("/chunk_index", "/file_index")) and not pa.types.is_integer(field.type):
            raise LlakeyError(
                f"Expected whole numbers in {field.name} of {path}, got {field.type}; do not use this dataset."
            )


def _check_pictures(path: Path, keys: Iterable[str]) -> None:
    """Each picture's cell holds the picture; the bytes are read only where a path beside them could be followed."""
    with reading(path, "parquet file"), pq.ParquetFile(path) as file:
        for key in keys:
            index = file.schema_arrow.get_field_index(key)
            if index < 0:
                continue
            kind = file.schema_arrow.field(index).type
            members = {kind.field(i).name: kind.field(i).type for i in range(kind.num_fields)}
            if not pa.types.is_struct(kind) or not _is_binary(members.get("bytes", pa.null())):
                raise LlakeyError(
                    f"Expected embedded pictures in {key} of {path}, got {kind}, which names files elsewhere; do not "
                    "use this dataset, or embed the pictures."
                )
            for group in range(file.num_row_groups) if "path" in members else ():
                _check_cells(file, group, key, path)


def _is_binary(kind: pa.DataType) -> bool:
    return pa.types.is_binary(kind) or pa.types.is_large_binary(kind)


def _check_cells(file: pq.ParquetFile, group: int, key: str, path: Path) -> None:
    named = file.read_row_group(group, columns=[f"{key}.path"])[key].combine_chunks().field("path").to_pylist()
    if not any(name is not None and not _EMBEDDED.fullmatch(str(name)) for name in named):
        return
    cells = file.read_row_group(group, columns=[f"{key}.bytes"])[key].combine_chunks()
    empty = cells.field("bytes").is_null().to_pylist()
    for row, (name, lacks) in enumerate(zip(named, empty, strict=True)):
        if lacks and name is not None:
            raise LlakeyError(
                f"Expected embedded pictures in {key} of {path}, got a cell that names the file {str(name)[:200]!r} "
                f"(row {row} of row group {group}); do not use this dataset, or embed the picture."
            )
