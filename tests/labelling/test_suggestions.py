"""What is offered while an instruction is typed."""

from pathlib import Path

import pytest

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.labelling.session import LabelSession
from lerobot_llakey.labelling.suggestions import suggest


@pytest.fixture
def session(found: list[FoundKeyframes], tmp_path: Path) -> LabelSession:
    session = LabelSession(found, tmp_path / "a.csv", BASIC_GRAMMAR)
    for episode, frame, text in (
        (0, 10, "move to the top of the blue cup"),
        (0, 20, "grasp the blue cup"),
        (0, 39, "raise the robotic arm"),
        (2, 10, "grasp the top handle"),
        (2, 20, "hold tight"),
    ):
        session.say(episode, frame, text)
    return session


def test_without_a_word_come_texts_of_the_same_segment_first_and_all_forms(session: LabelSession) -> None:
    offered = suggest(session, 1, 1, "")
    assert offered.texts[0] == "grasp the blue cup" and len(offered.texts) == 4 and not offered.valid
    assert "hold tight" not in offered.texts  # outside the grammar
    assert len(offered.forms) == len(BASIC_GRAMMAR.templates) and "grasp <thing>" in offered.forms


def test_typed_words_leave_the_texts_that_hold_them(session: LabelSession) -> None:
    assert suggest(session, 1, 0, "gra").texts == ["grasp the blue cup", "grasp the top handle"]
    assert suggest(session, 1, 0, "top cup").texts == ["move to the top of the blue cup"]


def test_a_thing_named_elsewhere_completes_another_action(session: LabelSession) -> None:
    offered = suggest(session, 1, 2, "release the blu")
    assert offered.texts == ["release the blue cup"] and offered.valid
    assert "push the block to the top handle" in suggest(session, 1, 2, "push the block to the top").texts
    assert suggest(session, 1, 2, "release the blue cup").texts == []


def test_outside_the_grammar_the_nearest_forms_are_told(session: LabelSession) -> None:
    offered = suggest(session, 1, 0, "grsp it please to")
    assert not offered.valid and "grasp <thing>" in offered.forms and len(offered.forms) == 3


def test_where_any_sentence_is_an_instruction_there_are_no_forms(found: list[FoundKeyframes], tmp_path: Path) -> None:
    session = LabelSession(found, tmp_path / "b.csv", Grammar.load("free"))
    session.say(0, 10, "wipe the table")
    offered = suggest(session, 1, 0, "wi")
    assert offered.valid and offered.texts == ["wipe the table"] and offered.forms == []


def test_an_episode_that_is_not_there_is_refused(session: LabelSession) -> None:
    with pytest.raises(LlakeyError, match="Expected an episode of 3, got 8"):
        suggest(session, 8, 0, "")
