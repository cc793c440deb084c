"""The CSV file of keyframes: written, read again, corrected by hand, and refused in one sentence."""

import csv
from pathlib import Path

import pytest

from fakes_found import three_episodes
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.keyframe_file import COLUMNS, Keyframe, discovered, read_keyframes, write_keyframes
from lerobot_llakey.errors import LlakeyError, MissingFileError


@pytest.fixture
def found() -> list[FoundKeyframes]:
    return three_episodes()


def test_what_was_written_is_read(found: list[FoundKeyframes], tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    keyframes = {episode.episode: discovered(episode) for episode in found}
    keyframes[1] = (Keyframe(7, 'grasp the "big", red cup'), Keyframe(39, "raise the robotic arm"))
    write_keyframes(path, found, keyframes)
    assert read_keyframes(path, found) == keyframes
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS and len(rows) == 8
    first = ("1", "0", "7", "0.70", "open", "lift the cup", 'grasp the "big", red cup')
    assert tuple(rows[3].values()) == first
    assert rows[4]["gripper"] == "closed" and rows[4]["time"] == "3.90"


def test_rows_may_be_deleted_moved_and_added_in_any_order(found: list[FoundKeyframes], tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("frame,episode,instruction\n39,0,c\n12,0,b\n5,0, a \n", encoding="utf-8-sig")
    read = read_keyframes(path, found)
    assert read[0] == (Keyframe(5, "a"), Keyframe(12, "b"), Keyframe(39, "c"))
    assert read[1] == discovered(found[1])


def test_a_last_frame_that_is_left_out_has_no_instruction(found: list[FoundKeyframes], tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("episode,frame,instruction\n0,5,a\n")
    assert read_keyframes(path, found)[0] == (Keyframe(5, "a"), Keyframe(39))


def test_a_file_without_frames_names_discovered_keyframes(found: list[FoundKeyframes], tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("episode,segment,instruction\n0,0,a\n0,2,c\n")
    assert read_keyframes(path, found)[0] == (Keyframe(10, "a"), Keyframe(20), Keyframe(39, "c"))


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("episode,instruction\n0,a\n", "Expected the columns episode, segment, instruction in .*, got episode, instr"),
        ("", "got none; correct its first line"),
        ("episode,frame,instruction\n0,x,a\n", "Expected a whole number as frame in line 2 of .*, got 'x'"),
        ("episode,frame,instruction\n0\n", "Expected a whole number as frame in line 2 of .*, got None"),
        ("episode,frame,instruction\n9,5,a\n", "Expected an episode of the dataset's 3 in line 2 of .*, got 9"),
        ("episode,frame,instruction\n0,0,a\n", "Expected a frame from 1 to 39, the last of episode 0, .* got 0"),
        ("episode,frame,instruction\n0,40,a\n", "Expected a frame from 1 to 39, .* got 40"),
        ("episode,frame,instruction\n0,5,a\n0,5,b\n", "Expected frame 5 of episode 0 once, got it again in line 3"),
        ("episode,segment,instruction\n0,3,a\n", "Expected a segment below 3 in line 2 of .*, got 3"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(
    rows: str, sentence: str, found: list[FoundKeyframes], tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(rows)
    with pytest.raises(LlakeyError, match=sentence):
        read_keyframes(path, found)


def test_a_file_that_is_missing_or_no_text_is_refused(found: list[FoundKeyframes], tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="Expected a CSV file of keyframes at"):
        read_keyframes(tmp_path / "none.csv", found)
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(LlakeyError, match="Expected a readable CSV file"):
        read_keyframes(tmp_path / "a.csv", found)
