"""Opening a dataset that a person names: what is missing or broken is said in one sentence, before LeRobot looks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import packaging.version
import pyarrow.parquet as pq
from huggingface_hub.errors import HfHubHTTPError, HFValidationError, LocalEntryNotFoundError, OfflineModeIsEnabled
from lerobot.datasets.dataset_metadata import CODEBASE_VERSION, LeRobotDatasetMetadata
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.utils import INFO_PATH
from lerobot.utils.constants import HF_LEROBOT_HOME

from lerobot_llakey.checks.foreign_files import refuse_paths_outside
from lerobot_llakey.errors import LlakeyError, MissingFileError, said
from lerobot_llakey.files import reading

_NOT_FETCHED = (HfHubHTTPError, HFValidationError, LocalEntryNotFoundError, OfflineModeIsEnabled, ConnectionError)


def open_dataset(repo_id: str, root: Path | None = None) -> LeRobotDataset:
    """Open a dataset in a folder; without a folder in LeRobot's home folder or, if it is not there, from the Hub.

    Args:
        repo_id: its name.
        root: its folder.

    Raises:
        MissingFileError: if there is no such folder, or a file of it is missing.
        LlakeyError: if it cannot be read: cut off, of another version of LeRobot, not to be had from the Hub.
    """
    folder = HF_LEROBOT_HOME / repo_id if root is None else root
    if root is None and not folder.exists():
        return _fetched(repo_id)
    open_metadata(folder)
    with reading(folder, "dataset"):
        return LeRobotDataset(repo_id, root=folder)


def open_metadata(folder: Path) -> LeRobotDatasetMetadata:
    """What a dataset says about itself, once all its files are there and have their ends.

    Args:
        folder: of the dataset.

    Raises:
        MissingFileError: if there is no such folder, or a file of it is missing.
        LlakeyError: if it cannot be read, is of another version of LeRobot, or names files outside its folder.
    """
    if not folder.is_dir():
        raise MissingFileError(f"Expected the folder of a dataset at {folder}, found none; check --root.")
    if not (folder / INFO_PATH).is_file():
        raise MissingFileError(
            f"Expected a dataset in {folder}, got a folder without {INFO_PATH}; check --root, or fetch or make it anew."
        )
    _check_info(folder)
    refuse_paths_outside(folder)
    for path in sorted((folder / "meta").rglob("*.parquet")):
        _check_parquet(path)
    with reading(folder, "dataset"):
        meta = LeRobotDatasetMetadata("local/opened", root=folder)
        if meta.total_episodes and meta.episodes is None:
            raise MissingFileError(f"Expected the episodes of {folder} in meta/episodes, found none; fetch it anew.")
        data = {meta.root / meta.get_data_file_path(episode) for episode in range(meta.total_episodes)}
        videos = {
            meta.root / meta.get_video_file_path(episode, key)
            for episode in range(meta.total_episodes)
            for key in meta.video_keys
        }
    for path in sorted(data | videos):
        if not path.is_file():
            raise MissingFileError(
                f"Expected a whole dataset in {folder}, got one without {path.relative_to(folder)}; fetch or make it "
                "anew."
            )
    for path in sorted(data):
        _check_parquet(path)
    return meta


def _check_info(folder: Path) -> None:
    path = folder / INFO_PATH
    with reading(path, "JSON file"):
        info: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        version = packaging.version.parse(str(info["codebase_version"]))
        for feature in dict(info["features"]).values():
            _ = feature["dtype"], list(feature["shape"])
        _ = int(info["total_episodes"]), int(info["total_frames"]), float(info["fps"])
    wanted = packaging.version.parse(CODEBASE_VERSION)
    if version.major != wanted.major:
        raise LlakeyError(
            f"Expected a dataset of LeRobot's version {CODEBASE_VERSION} in {folder}, got {info['codebase_version']}; "
            "convert it with LeRobot's conversion scripts (lerobot/scripts/convert_dataset_*)."
        )


def _check_parquet(path: Path) -> None:
    with reading(path, "parquet file"), pq.ParquetFile(path):
        pass  # its footer comes last: a file that was cut off has none


def _fetched(repo_id: str) -> LeRobotDataset:
    try:
        meta = LeRobotDatasetMetadata(repo_id)
    except _NOT_FETCHED as error:
        raise MissingFileError(
            f"Expected a dataset {repo_id} in {HF_LEROBOT_HOME} or on the Hub, got neither ({said(error, 160)}); give "
            "the folder of one by --root."
        ) from error
    _check_info(meta.root)
    refuse_paths_outside(meta.root)  # before files are fetched to where it says
    with reading(meta.root, "dataset"):
        dataset = LeRobotDataset(repo_id)
    refuse_paths_outside(dataset.root)
    return dataset
