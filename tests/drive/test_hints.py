"""Words outside the grammar are answered with what would be read."""

import pytest

from lerobot_llakey import hints
from lerobot_llakey.drive.hints import explain, read_instruction
from lerobot_llakey.grammar_data import LONGEST
from lerobot_llakey.hints import nearest_forms
from lerobot_llakey.instructions import BASIC_GRAMMAR

KNOWN = ["grasp the top handle", "grasp the bottom handle", "pull the top drawer open"]


def test_what_can_be_read_is_made_canonical() -> None:
    assert read_instruction(" Grab the  top handle. ", KNOWN) == "grasp the top handle"


def test_the_sentence_names_text_suggestion_forms_and_that_nothing_moved() -> None:
    with pytest.raises(ValueError) as error:
        read_instruction("grap the top handel", KNOWN)
    sentence = str(error.value)
    assert sentence.startswith("Expected a basic action, got 'grap the top handel'; did you mean 'grasp ")
    assert "<thing>" in sentence and sentence.endswith("Nothing was moved.") and "\n" not in sentence


def test_without_anything_near_only_forms_are_named() -> None:
    assert "did you mean" not in explain("dance", KNOWN) and "the nearest forms are" in explain("", KNOWN)


def test_a_form_with_its_slots_filled_is_read() -> None:
    for template in BASIC_GRAMMAR.templates.values():
        for text in template.texts:
            filled = text.format(pose="top", thing="the lid", target="the jar", held="the cup")
            assert read_instruction(filled)
            assert text.split()[0] == nearest_forms(filled, count=1)[0].split()[0]


def test_of_a_long_text_the_beginning_is_compared_and_quoted(monkeypatch: pytest.MonkeyPatch) -> None:
    compared: list[str] = []
    monkeypatch.setattr(hints, "get_close_matches", lambda text, *rest, **how: compared.append(text) or [])
    said = explain("gras the top handle " * 100_000, [])
    assert len(compared[0]) <= LONGEST and "grasp <thing>" in said
    assert len(said) < 800 and "(2000000 characters)" in said
