import pytest

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.hierarchy.decision import Choice, Said, choose

FALLBACK = "raise the robotic arm"


def test_says_whose_words_were_taken() -> None:
    last: Choice | None = None
    taken = []
    for text in ("gibberish", "Grab the lid.", "gibberish"):
        last = choose(Said(text, "policy", 0.5), last, BASIC_GRAMMAR, FALLBACK)
        taken.append((last.instruction, last.source, last.likelihood, last.unparsable, last.said))
    assert taken == [
        (FALLBACK, "fallback", None, True, "gibberish"),
        ("grasp the lid", "policy", 0.5, False, "Grab the lid."),
        ("grasp the lid", "previous", None, True, "gibberish"),
    ]
    assert last is not None and last.parsed == BASIC_GRAMMAR.parse("grab the lid")


def test_free_text_is_taken_as_it_is_and_nothing_readable_keeps_still() -> None:
    free = Grammar.load("free")
    assert choose(Said("Please  hurry", "person"), None, free, None).instruction == "Please hurry"
    with pytest.raises(ValueError, match="so the arm keeps still"):
        choose(Said("gibberish", "policy"), None, BASIC_GRAMMAR, None)
