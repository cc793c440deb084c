"""The record of a collection: read, or refused in one sentence."""

import json
from pathlib import Path

import pytest

from lerobot_llakey.datasets.collect_record import RECORD, read_record
from lerobot_llakey.errors import LlakeyError

WHOLE = {"settings": {"fps": 10}, "episodes": 3, "discarded": {"not done": 1}}


def write(root: Path, text: str) -> Path:
    (root / RECORD).parent.mkdir()
    (root / RECORD).write_text(text)
    return root


def test_a_record_is_read(tmp_path: Path) -> None:
    assert read_record(write(tmp_path, json.dumps(WHOLE))) == WHOLE


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match=r"absent or collected by llakey, got another folder; choose a new one"):
        read_record(tmp_path)


@pytest.mark.parametrize(
    "text", ["{", json.dumps({"settings": {}, "episodes": 3}), json.dumps(WHOLE | {"episodes": "x"})]
)
def test_a_broken_record_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(LlakeyError, match="Expected a readable record of a collection"):
        read_record(write(tmp_path, text))
