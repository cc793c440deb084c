"""The forms of basic actions that come nearest to a text."""

import pytest

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hints import forms, nearest_forms, nearest_known


def test_all_forms_are_told_once_each_and_none_of_free_text() -> None:
    assert forms()[2:4] == ["grasp <thing>", "release <thing>"] and len(forms()) == 16
    assert forms(Grammar.load("free")) == []


@pytest.mark.parametrize(
    ("text", "form"),
    [
        ("gras the handle", "grasp <thing>"),
        ("move to the middle of the jar", "move to the <top|front|back|left side|right side|bottom> of <thing>"),
        ("skrew the lid in", "screw <thing> in"),
        ("twist lid inn", "twist <thing> in"),
        ("push the lid too the jar", "push <thing> to <target>"),
    ],
)
def test_the_nearest_form_comes_first(text: str, form: str) -> None:
    assert nearest_forms(text)[0] == form


def test_the_nearest_known_instruction_is_found_if_any_is_near() -> None:
    known = ["grasp the top handle", "pull the top drawer open"]
    assert nearest_known("grap the top handel", known) == known[0] and nearest_known("dance", known) is None
