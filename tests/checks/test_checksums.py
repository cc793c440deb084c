"""Files that changed since a dataset was written are told; those of a dataset without notes are not looked at."""

from pathlib import Path

import pytest

from lerobot_llakey.checks.checksums import CHECKSUMS, check_checksums, refuse_changed_files, write_checksums
from lerobot_llakey.errors import LlakeyError


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    for name in ("data/a.parquet", "meta/info.json", "videos/front/b.mp4"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(name.encode() * 100)
    write_checksums(tmp_path)
    return tmp_path


def test_what_is_as_it_was_passes(dataset: Path) -> None:
    (dataset / "README.md").write_text("a card may come later")
    (dataset / "data" / "a.parquet").touch()
    assert list(check_checksums(dataset)) == []


@pytest.mark.parametrize("name", ["data/a.parquet", "meta/info.json", "videos/front/b.mp4"])
def test_one_bit_is_told(name: str, dataset: Path) -> None:
    content = bytearray((dataset / name).read_bytes())
    content[17] ^= 1
    (dataset / name).write_bytes(content)
    assert [(finding.column, finding.certain) for finding in check_checksums(dataset)] == [(name, True)]
    with pytest.raises(LlakeyError, match=f"{name}.*delete {CHECKSUMS}"):
        refuse_changed_files(dataset)


def test_a_file_that_was_slipped_in_is_told(dataset: Path) -> None:
    (dataset / "data" / "c.parquet").write_bytes(b"more")
    assert [finding.column for finding in check_checksums(dataset)] == ["data/c.parquet"]


def test_episodes_may_be_fetched_one_by_one(dataset: Path) -> None:
    (dataset / "videos/front/b.mp4").unlink()
    assert list(check_checksums(dataset)) == []


def test_datasets_of_others_have_no_notes(dataset: Path) -> None:
    (dataset / CHECKSUMS).unlink()
    (dataset / "data/a.parquet").write_bytes(b"other")
    assert list(check_checksums(dataset)) == []


def test_notes_that_are_broken_are_named(dataset: Path) -> None:
    (dataset / CHECKSUMS).write_text("{")
    with pytest.raises(LlakeyError, match="list of checksums"):
        list(check_checksums(dataset))
