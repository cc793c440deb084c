"""Instructions from files and typed ones, held against the grammar."""

import json
from pathlib import Path

import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.datasets import wording as module
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.keyframe_file import discovered, write_keyframes
from lerobot_llakey.datasets.wording import Wording, read_instructions, refuse_outside_grammar
from lerobot_llakey.errors import LlakeyError

TEXTS = ["move to the top of the cup", "grasp the cup"]


@pytest.fixture
def found() -> list[FoundKeyframes]:
    """Two episodes of two segments."""
    hand, opened = np.zeros((26, 8)), np.ones(26, dtype=bool)
    return [
        FoundKeyframes(episode, "take the cup", hand, schema.HAND_NAMES, opened, [10, 25], 10) for episode in range(2)
    ]


def test_a_filled_in_template_is_read_again(found: list[FoundKeyframes], tmp_path: Path) -> None:
    path = tmp_path / "instructions.csv"
    write_keyframes(path, found, {episode.episode: discovered(episode) for episode in found})
    lines = path.read_text().splitlines()
    assert lines[0] == "episode,segment,frame,time,gripper,task,instruction"
    assert lines[2] == "0,1,25,2.50,open,take the cup,"
    filled = [lines[0], *(line + TEXTS[index % 2] for index, line in enumerate(lines[1:]))]
    path.write_text("\n".join(filled))
    assert read_instructions(path).instructions == {0: TEXTS, 1: TEXTS}


def test_json_instructions_are_read(tmp_path: Path) -> None:
    path = tmp_path / "instructions.json"
    path.write_text(json.dumps({"0": TEXTS, "3": TEXTS[:1]}))
    assert read_instructions(path) == Wording({0: TEXTS, 3: TEXTS[:1]})


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", "episode,instruction\n0,grasp the cup\n", "columns episode, segment, instruction"),
        ("b.csv", "episode,segment,instruction\n0,1,grasp the cup\n", "segment 0 of episode 0"),
        ("c.json", '["grasp the cup"]', "something else"),
    ],
)
def test_instruction_files_of_another_form_are_named(name: str, content: str, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(ValueError, match=message):
        read_instructions(tmp_path / name)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="--template"):
        read_instructions(tmp_path / "none.csv")


def test_typed_instructions_are_offered_again_for_the_next_episode(found: list[FoundKeyframes]) -> None:
    prompts: list[str] = []
    answers = iter([*TEXTS, "", ""])

    def ask(prompt: str) -> str:
        prompts.append(prompt)
        return next(answers)

    assert module.ask_instructions(found, ask) == {0: TEXTS, 1: TEXTS}
    assert prompts[0] == "episode 0 (take the cup), 0.0 to 1.0 s: "
    assert prompts[3] == "episode 1 (take the cup), 1.0 to 2.5 s [grasp the cup]: "


def test_all_instructions_of_a_file_outside_the_grammar_are_listed_with_lines_and_nearest_forms(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "episode,segment,instruction\n0,0,gras the cup\n0,1,grasp the cup\n1,0,gras the cup\n1,1,pull it opne\n"
    )
    with pytest.raises(LlakeyError) as error:
        read_instructions(path)
    sentence = str(error.value)
    assert "got 3 outside it" in sentence and str(path) in sentence and "\n" not in sentence
    assert "'gras the cup' (line 2, line 4; the nearest form is 'grasp <thing>')" in sentence
    assert "'pull it opne' (line 5; the nearest form is 'pull <thing> open')" in sentence
    path.with_suffix(".json").write_text(json.dumps({"3": ["grasp the cup", "dance"]}))
    with pytest.raises(LlakeyError, match=r"'dance' .episode 3, segment 1;"):
        read_instructions(path.with_suffix(".json"))


def test_instructions_that_are_still_empty_are_left_to_be_counted() -> None:
    refuse_outside_grammar({"line 2": "", "line 3": " "})


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"episode,segment,instruction\n0,0,grasp the cup\n0,0,grasp the lid\n", "once, got it again in line 3"),
        (b"episode,segment,instruction\n0,0,\xff\xfe\n", "utf-8"),
    ],
)
def test_doubled_segments_and_other_bytes_are_refused(content: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(LlakeyError, match=message):
        read_instructions(tmp_path / "a.csv")


def test_what_is_typed_outside_the_grammar_is_asked_for_again(found: list[FoundKeyframes]) -> None:
    prompts: list[str] = []
    answers = iter(["gras it", *TEXTS, "", ""])

    def ask(prompt: str) -> str:
        prompts.append(prompt)
        return next(answers)

    assert module.ask_instructions(found, ask) == {0: TEXTS, 1: TEXTS}
    assert "grasp <thing>" in prompts[1] and len(prompts) == 5


def test_the_end_of_the_input_is_one_sentence(found: list[FoundKeyframes]) -> None:
    def ask(prompt: str) -> str:
        raise EOFError

    with pytest.raises(LlakeyError, match="segment 0 of episode 0, got the end of the input"):
        module.ask_instructions(found, ask)


def test_rows_may_be_deleted_moved_and_added(tmp_path: Path) -> None:
    path = tmp_path / "instructions.csv"
    path.write_text(f"episode,segment,frame,instruction\n0,1,25,{TEXTS[1]}\n0,,7,{TEXTS[0]}\n")
    assert read_instructions(path) == Wording({0: TEXTS}, {0: [7, 25]})


def test_a_frame_named_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "instructions.csv"
    path.write_text(f"episode,frame,instruction\n0,7,{TEXTS[0]}\n0,7,{TEXTS[1]}\n")
    with pytest.raises(LlakeyError, match="frame 7 of episode 0 once"):
        read_instructions(path)
