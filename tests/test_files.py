"""Files and folders that appear whole or not at all."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from safetensors.torch import load_file

from lerobot_llakey.errors import FileInTheWayError, LlakeyError, MissingFileError
from lerobot_llakey.files import alone_in, alone_with, check_writable, reading, remove, replacing, write_whole
from lerobot_llakey.folders import new_folder


def test_a_file_is_replaced_only_when_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "a.json"
    write_whole(path, "old")
    with pytest.raises(KeyError), replacing(path) as fresh:
        fresh.write_text("half")
        raise KeyError
    assert path.read_text() == "old"
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"
    assert [file.name for file in path.parent.iterdir()] == ["a.json"]


def test_a_new_folder_appears_at_the_end_alone(tmp_path: Path) -> None:
    target = tmp_path / "dataset"
    with pytest.raises(KeyError), new_folder(target) as folder:
        folder.mkdir()
        raise KeyError
    assert not target.exists() and not folder.exists()
    folder.mkdir()  # as a killed run leaves it
    (folder / "half").touch()
    with new_folder(target) as folder:
        assert not folder.exists() and not target.exists()
        folder.mkdir()
        (folder / "whole").touch()
    assert [file.name for file in target.iterdir()] == ["whole"]


@pytest.mark.parametrize("kind", ["file", "link", "filled"])
def test_what_stands_where_a_new_folder_should_be_is_left_alone(tmp_path: Path, kind: str) -> None:
    target = tmp_path / "dataset"
    if kind == "file":
        target.touch()
    elif kind == "link":
        target.symlink_to(tmp_path / "nowhere")
    else:
        target.mkdir()
        (target / "mine").touch()
    with pytest.raises(FileInTheWayError, match="dataset"), new_folder(target):
        pass
    assert target.is_symlink() or target.exists()


def test_an_empty_folder_may_be_filled(tmp_path: Path) -> None:
    (tmp_path / "dataset").mkdir()
    with new_folder(tmp_path / "dataset") as folder:
        folder.mkdir()
        (folder / "whole").touch()
    assert (tmp_path / "dataset" / "whole").exists()


def test_a_folder_belongs_to_one_run_at_a_time(tmp_path: Path) -> None:
    with (
        alone_in(tmp_path / "table"),
        pytest.raises(LlakeyError, match=r"no other run in .*table"),
        alone_in(tmp_path / "table"),
    ):
        pass
    with alone_in(tmp_path / "table"), new_folder(tmp_path / "new") as folder:
        folder.mkdir()
        with pytest.raises(LlakeyError, match=r"no other run in .*new"), new_folder(tmp_path / "new"):
            pass


def test_a_file_belongs_to_one_process_at_a_time(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("a")
    with alone_with(file, "--instructions"):
        with (
            pytest.raises(LlakeyError, match="wait for it or give another --instructions"),
            alone_with(file, "--instructions"),
        ):
            pass
        with alone_with(tmp_path / "b.csv", "--instructions"):
            pass
    with alone_with(file, "--instructions"):
        assert file.read_text() == "a"
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_what_cannot_be_written_is_said_before_work(tmp_path: Path) -> None:
    check_writable(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    with pytest.raises(LlakeyError, match="file, which is no folder"):
        check_writable(tmp_path / "file" / "b")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    with pytest.raises(LlakeyError, match="dangling, which is no folder"):
        check_writable(tmp_path / "dangling" / "b")
    with pytest.raises(LlakeyError, match="GB of free space"):
        check_writable(tmp_path / "a", needed_bytes=10**18)
    with pytest.raises(LlakeyError, match="refused"):
        check_writable(Path("/proc/llakey"))


def test_removing_a_link_leaves_what_it_points_to(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    kept.mkdir()
    (tmp_path / "link").symlink_to(kept)
    remove(tmp_path / "link")
    remove(tmp_path / "nothing")
    assert kept.is_dir() and not (tmp_path / "link").is_symlink()


def test_a_broken_or_missing_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "config.json"
    with (
        pytest.raises(MissingFileError, match=r"Expected a JSON file at .*config\.json, found none"),
        reading(path, "JSON file"),
    ):
        pass
    path.write_bytes(b'{"a": \xff')
    with pytest.raises(LlakeyError, match=r"readable JSON file at .*config\.json, got"), reading(path, "JSON file"):
        json.loads(path.read_text(encoding="utf-8"))
    with pytest.raises(LlakeyError, match=r"readable weights at .*SafetensorError"), reading(path, "weights"):
        load_file(path)
    with pytest.raises(LlakeyError, match=r"readable table at .*Arrow"), reading(path, "table"):
        pq.read_table(path)
    with pytest.raises(MissingFileError, match=r"lacks a file .*nope"), reading(tmp_path, "dataset"):
        (tmp_path / "nope").read_bytes()
    with pytest.raises(ZeroDivisionError), reading(path):
        1 / 0  # noqa: B018
