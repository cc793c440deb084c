"""The grammar: every instruction that can be made has exactly one text, and every text one reading."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lerobot_llakey.instructions as grammar
from lerobot_llakey.instructions import (
    JOINING_WORDS,
    POSES,
    TEMPLATES,
    Instruction,
    canonical,
    gripper_implied,
    instruct,
    is_parsable,
    paraphrase,
    parse,
    parsed_or_none,
    render,
)

WORDS = st.one_of(
    st.sampled_from(
        [*sorted(JOINING_WORDS), "the", "of", "it", "grasp", "release", "with", "top", "red", "block", "arm"]
    ),
    st.text(min_size=0, max_size=6),
)
PHRASES = st.one_of(
    st.lists(
        st.sampled_from(["the", "of", "it", "grasp", "release", "move", "top", "red", "jar", "arm"]),
        min_size=1,
        max_size=6,
    ).map(" ".join),
    st.lists(WORDS, max_size=5).map(" ".join),
)


@st.composite
def _parts(draw: st.DrawFn) -> tuple[str, tuple[str, ...], int]:
    name = draw(st.sampled_from(list(TEMPLATES)))
    arguments = tuple(draw(st.sampled_from(POSES) if slot == "pose" else PHRASES) for slot in TEMPLATES[name].slots)
    return name, arguments, draw(st.integers(0, len(TEMPLATES[name].texts) - 1))


@given(_parts())
def test_an_instruction_is_rejected_or_comes_back_from_its_text(parts: tuple[str, tuple[str, ...], int]) -> None:
    try:
        instruction = Instruction(*parts)
    except ValueError as error:
        assert "noun phrase" in str(error)
        return
    assert parse(render(instruction)) == instruction


@given(st.text())
def test_any_text_parses_or_raises_value_error_and_never_breaks_gripper_implied(text: str) -> None:
    try:
        instruction = parse(text)
    except ValueError:
        assert gripper_implied(text) is None
    else:
        assert parse(render(instruction)) == instruction


def test_sixteen_templates_with_at_most_one_synonym_each_and_equal_slots() -> None:
    assert len(TEMPLATES) == 16
    for template in TEMPLATES.values():
        assert 1 <= len(template.texts) <= 2
        assert all(set(template.slots) == set(type(template)((text,)).slots) for text in template.texts)


@pytest.mark.parametrize(
    ("text", "template", "arguments"),
    [
        ("move to the left side of the top of the jar", "move", ("left side", "the top of the jar")),
        ("move to the top of the red jar and grasp it", "move_grasp", ("top", "the red jar")),
        ("move to the top of the box and release the bulb", "move_release", ("top", "the box", "the bulb")),
        ("rotate the cup to the upright pose and release it", "rotate_release", ("the cup", "the upright pose")),
        ("screw the lid in", "screw_in", ("the lid",)),
        ("raise the robotic arm", "raise", ()),
        ("pull the top drawer open", "pull_open", ("the top drawer",)),
    ],
)
def test_known_texts(text: str, template: str, arguments: tuple[str, ...]) -> None:
    assert parse(text) == Instruction(template, arguments)
    assert instruct(template, *arguments) == text


def test_case_spaces_and_full_stop_do_not_matter() -> None:
    assert parse(" Grasp  the Red block. ") == Instruction("grasp", ("the red block",))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("grasp the lid", False),
        ("go to the top of the lid and grab it", False),
        ("let go of the lid", True),
        ("move to the top of the box and release the lid", True),
        ("rotate the cup to the mark and release it", True),
        ("slide the block to the mark", None),
        ("grasp", None),
        ("grasp the lid and the jar", None),
    ],
)
def test_gripper_implied(text: str, expected: bool | None) -> None:
    assert gripper_implied(text) is expected


def test_canonical_and_paraphrase_keep_the_meaning() -> None:
    rng = np.random.default_rng(0)
    said = {paraphrase("grab the lid", rng) for _ in range(50)}
    assert said == {"grasp the lid", "grab the lid"}
    assert {canonical(text) for text in said} == {"grasp the lid"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("jump",), "a template out of"),
        (("grasp", ()), "Expected the arguments"),
        (("grasp", ("the lid",), 2), "a variant below 2"),
        (("grasp", ("The lid",)), "noun phrase of lower-case words"),
        (("grasp", ("the lid and the jar",)), "without 'and'"),
        (("grasp", ("",)), "noun phrase"),
        (("move", ("inside", "the jar")), "a pose out of"),
        (("grasp", ("the " + "very " * 50 + "red block",)), "at most 200 characters, got one of"),
    ],
)
def test_bad_instructions_are_refused_in_one_sentence(arguments: tuple, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Instruction(*arguments)


def test_texts_outside_the_grammar_are_told_apart() -> None:
    assert is_parsable("Grab the red block.") and not is_parsable("sing a song")
    assert parsed_or_none("sing a song") is None
    assert parsed_or_none("Grab the red block.") == parse("grab the red block")


@pytest.mark.parametrize("words", [500, 100_000])
def test_a_long_text_is_refused_unread_and_quoted_in_part(words: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grammar, "_read", lambda plain: pytest.fail(f"{len(plain)} characters were looked through"))
    text = "rotate the " + "a to the " * words
    with pytest.raises(ValueError, match=rf"got 'rotate .*\.\.\. \({len(text)} characters\)") as error:
        parse(text)
    assert len(str(error.value)) < 500
    assert not is_parsable(text) and gripper_implied(text) is None


def test_spaces_do_not_count_towards_the_length() -> None:
    assert parse("grasp" + " " * 10_000 + "the lid") == Instruction("grasp", ("the lid",))
