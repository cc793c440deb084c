"""The grammar: every instruction that can be made has exactly one text, and every text one reading."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import Instruction

BASIC = Grammar.load("basic")
FREE = Grammar.load("free")
OWN_DATA = {
    "templates": {
        "press": {"wordings": ["press {thing}", "push {thing} down", "hit {thing}"], "gripper": "closed"},
        "pour": {"wordings": ["pour {held} into {target}"]},
        "up": {"wordings": ["come up"]},
        "side": {"wordings": ["look at the {pose} of {thing}"]},
    },
    "poses": ["near side", "far side"],
    "straight_up": ["up"],
}
OWN = Grammar.from_data(OWN_DATA)
parse, canonical, paraphrase, instruct = BASIC.parse, BASIC.canonical, BASIC.paraphrase, BASIC.instruct
gripper_implied, is_parsable, parsed_or_none = BASIC.gripper_implied, BASIC.is_parsable, BASIC.parsed_or_none

WORDS = st.one_of(
    st.sampled_from(
        [
            *sorted(BASIC.joining | OWN.joining),
            "the",
            "of",
            "it",
            "grasp",
            "release",
            "with",
            "top",
            "red",
            "block",
            "arm",
        ]
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
def _parts(draw: st.DrawFn) -> tuple[Grammar, Instruction]:
    grammar = draw(st.sampled_from([BASIC, OWN]))
    name = draw(st.sampled_from(list(grammar.templates)))
    template = grammar.templates[name]
    filled = tuple(draw(st.sampled_from(grammar.poses) if slot == "pose" else PHRASES) for slot in template.slots)
    return grammar, Instruction(name, filled, draw(st.integers(0, len(template.texts) - 1)))


@given(_parts())
def test_an_instruction_is_rejected_or_comes_back_from_its_text(parts: tuple[Grammar, Instruction]) -> None:
    grammar, instruction = parts
    try:
        text = grammar.render(instruction)
    except LlakeyError as error:
        assert "noun phrase" in str(error)
        return
    assert grammar.parse(text) == instruction
    assert grammar.parse(grammar.canonical(text)).arguments == instruction.arguments


@given(st.text())
def test_any_text_parses_or_raises_value_error_and_never_breaks_gripper_implied(text: str) -> None:
    try:
        instruction = parse(text)
    except ValueError:
        assert gripper_implied(text) is None
    else:
        assert parse(BASIC.render(instruction)) == instruction


def test_sixteen_templates() -> None:
    assert len(BASIC.templates) == 16


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
        BASIC.render(Instruction(*arguments))


def test_texts_outside_the_grammar_are_told_apart() -> None:
    assert is_parsable("Grab the red block.") and not is_parsable("sing a song")
    assert parsed_or_none("sing a song") is None
    assert parsed_or_none("Grab the red block.") == parse("grab the red block")


@pytest.mark.parametrize("words", [500, 100_000])
def test_a_long_text_is_refused_unread_and_quoted_in_part(words: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BASIC, "_read", lambda plain: pytest.fail(f"{len(plain)} characters were looked through"))
    text = "rotate the " + "a to the " * words
    with pytest.raises(ValueError, match=rf"got 'rotate .*\.\.\. \({len(text)} characters\)") as error:
        parse(text)
    assert len(str(error.value)) < 500
    assert not is_parsable(text) and gripper_implied(text) is None


def test_spaces_do_not_count_towards_the_length() -> None:
    assert parse("grasp" + " " * 10_000 + "the lid") == Instruction("grasp", ("the lid",))


def test_free_text_is_any_sentence_and_implies_nothing() -> None:
    text = " Pick  up the Cup, please!"
    assert FREE.canonical(text) == "Pick up the Cup, please!"
    assert FREE.paraphrase(text, np.random.default_rng(0)) == text
    assert FREE.gripper_implied("release the lid") is None
    assert FREE.render(FREE.parse(text)) == FREE.canonical(text)
    assert not any(map(FREE.is_parsable, ("", "  ", "stop <next goal>", "a " * 501)))


def test_a_grammar_comes_back_from_its_data_and_from_a_file(tmp_path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(OWN_DATA))
    assert Grammar.load(path) == OWN == Grammar.from_data(OWN.to_data()) == pickle.loads(pickle.dumps(OWN))
    assert OWN.gripper_implied("Push the bell down.") is False and OWN.straight_up == ("up",)
    assert [Grammar.from_data(one.to_data()) for one in (BASIC, FREE)] == [BASIC, FREE]
    assert Grammar.from_data(None) == BASIC != OWN


@pytest.mark.parametrize(
    ("templates", "message"),
    [
        ({"a": ["press {x}", "push {y}"]}, "template 'a' .* slots of 'press {x}'"),
        ({"a": ["press {x}"], "b": ["press {y}"]}, "'a' .* and 'b' .* both read 'press thing'"),
        ({"a": ["press {x}"], "b": ["press it"]}, "both read 'press it'"),
        ({"a": ["see {pose} of {x}"], "b": ["see {x} of {y}"]}, "both read 'see front of"),
        ({"a": ["press {x} {y}"]}, "a word between two slots in template 'a'"),
        ({"a": ["press {pose} of {x} {"]}, "plain words and slots"),
        ({"a": ["Press {x}"]}, "lower case"),
        ({"a": []}, "a list of 1 to"),
        ({}, "templates in"),
    ],
)
def test_broken_grammars_are_refused_in_one_sentence(templates: dict, message: str) -> None:
    data = {"poses": ["front"], "templates": {name: {"wordings": texts} for name, texts in templates.items()}}
    with pytest.raises(LlakeyError, match=message) as error:
        Grammar.from_data(data)
    assert str(error.value).startswith("Expected ")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("templates: !!python/object/apply:os.getcwd []", "YAML"),
        ("a: &a [x]\nb: *a", "without aliases"),
        ("x: [", "YAML"),
        ("templates: {a: {wordings: [go], colour: red}}", "template 'a' of .*bad.yaml, got 'colour'"),
        ("templates: {a: {wordings: [go], gripper: half}}", "gripper open or closed in template 'a'"),
        ("templates: {a: {wordings: [go]}}\nstraight_up: [b]", "got 'b'"),
        ("#" * 200_001, "bytes"),
    ],
)
def test_bad_files_are_refused_by_name(text: str, message: str, tmp_path) -> None:
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(LlakeyError, match=message) as error:
        Grammar.load(tmp_path / "bad.yaml")
    assert "bad.yaml" in str(error.value)
