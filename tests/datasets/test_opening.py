"""Datasets that are missing or broken are named in one sentence, without a look at the Hub."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import PIL.Image
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.datasets import opening as module
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.errors import LlakeyError, MissingFileError

INFO, EPISODES = "meta/info.json", "meta/episodes/chunk-000/file-000.parquet"
DATA, TASKS = "data/chunk-000/file-000.parquet", "meta/tasks.parquet"


@pytest.fixture(autouse=True)
def no_hub(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asking the Hub fails the test."""

    def asked(*_: object, **__: object) -> None:
        raise AssertionError("the Hub was asked")

    monkeypatch.setattr(LeRobotDatasetMetadata, "_pull_from_repo", asked)
    monkeypatch.setattr(LeRobotDataset, "_download", asked)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole dataset."""
    return fake_keysteps(tmp_path_factory.mktemp("made") / "data", episodes=1, image_size=16).root


@pytest.fixture
def root(tmp_path: Path, made: Path) -> Path:
    """A copy that may be damaged."""
    return Path(shutil.copytree(made, tmp_path / "data"))


def test_a_whole_dataset_is_opened(root: Path) -> None:
    assert len(open_dataset("l/x", root)) == 6


def test_no_folder_and_a_folder_of_something_else_are_named_and_left_as_they_are(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="nowhere, found none; check --root"):
        open_dataset("l/x", tmp_path / "nowhere")
    with pytest.raises(MissingFileError, match=r"without meta/info\.json"):
        open_dataset("l/x", tmp_path)
    assert list(tmp_path.iterdir()) == []


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def flip(path: Path) -> None:
    path.write_bytes(b"\xff\xfe" * 100)


@pytest.mark.parametrize("name", [INFO, EPISODES, DATA, TASKS, "meta/stats.json"])
@pytest.mark.parametrize("damage", [cut, flip])
def test_a_broken_file_is_named(root: Path, name: str, damage: Callable[[Path], None]) -> None:
    damage(root / name)
    with pytest.raises(LlakeyError) as error:
        open_dataset("l/x", root)
    assert str(root) in str(error.value) and "\n" not in str(error.value)
    if not name.endswith("stats.json"):
        assert name in str(error.value)


@pytest.mark.parametrize("name", [EPISODES, DATA, TASKS])
def test_a_missing_file_is_said(root: Path, name: str) -> None:
    (root / name).unlink()
    with pytest.raises(LlakeyError, match=r"(make|fetch) it anew"):
        open_dataset("l/x", root)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"codebase_version": "v2.1"}, "got v2.1; convert"),
        ({"codebase_version": "next"}, r"info\.json"),
        ({"features": None}, r"info\.json"),
        ({"total_episodes": "many"}, r"info\.json"),
    ],
)
def test_a_description_that_cannot_be_used_is_named(root: Path, change: dict[str, object], message: str) -> None:
    info = json.loads((root / INFO).read_text())
    (root / INFO).write_text(json.dumps(info | change))
    with pytest.raises(LlakeyError, match=message):
        open_dataset("l/x", root)


def test_a_name_that_is_neither_here_nor_on_the_hub_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def offline(*_: object, **__: object) -> None:
        raise module.OfflineModeIsEnabled("Cannot reach it: offline mode is enabled.")

    monkeypatch.setattr(module, "HF_LEROBOT_HOME", tmp_path)
    monkeypatch.setattr(module, "LeRobotDatasetMetadata", offline)
    with pytest.raises(MissingFileError, match=r"a dataset me/none in .* or on the Hub, got neither .*--root"):
        open_dataset("me/none")


def test_a_dataset_that_names_files_outside_its_folder_is_refused(root: Path) -> None:
    info = json.loads((root / INFO).read_text())
    (root / INFO).write_text(json.dumps(info | {"data_path": "../../secret/file-{file_index:03d}.parquet"}))
    with pytest.raises(LlakeyError, match=r"data_path .* got '../../secret"):
        open_dataset("l/x", root)


def test_a_picture_that_is_a_file_elsewhere_is_refused_before_it_is_merged(root: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.png"
    PIL.Image.new("RGB", (16, 16)).save(secret)
    table, key = pq.read_table(root / DATA), schema.image_key("front")
    cells = pa.array([{"bytes": None, "path": str(secret)}] * len(table), table.schema.field(key).type)
    pq.write_table(table.set_column(table.column_names.index(key), key, cells), root / DATA)
    with pytest.raises(LlakeyError, match=r"names the file .*secret\.png"):
        merge([root], tmp_path / "merged", "l/m")
    assert not (tmp_path / "merged").exists()
