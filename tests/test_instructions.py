"""The simulator's instructions are of the basic grammar."""

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR, instruct, parse


def test_instructions_are_of_the_basic_grammar() -> None:
    assert Grammar.load("basic") == BASIC_GRAMMAR
    assert parse(instruct("grasp", "the lid")).arguments == ("the lid",)
