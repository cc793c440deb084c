"""Instructions in the basic grammar, which the simulator's experts speak."""

from __future__ import annotations

from lerobot_llakey.grammar import BASIC, Grammar
from lerobot_llakey.grammar_data import Instruction

__all__ = ["BASIC_GRAMMAR", "Instruction", "instruct", "parse"]

BASIC_GRAMMAR = Grammar.load(BASIC)
instruct = BASIC_GRAMMAR.instruct
"""The canonical text of a template filled with arguments."""
parse = BASIC_GRAMMAR.parse
"""The only reading of a text."""
