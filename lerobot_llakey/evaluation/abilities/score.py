"""Counting right answers: as a whole, by verb and by objects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import Instruction
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.reporting.statistics import wilson

OUTSIDE = "(outside the grammar)"
"""The verb of a text that is no basic action."""
MEASURES = ("exact", "verb", "objects")


@dataclass
class Score:
    """Counts of right answers.

    Attributes:
        samples: answers looked at.
        exact: answers that are the expected instruction, wordings of the same template counting as one.
        verb: answers with the expected template, whatever their objects.
        objects: answers with the expected noun phrases, whatever their template.
        unparsable: answers that are not in the grammar, and not the expected text either.
        confusions: how often which wrong answer was given, by (expected, answer).
        verbs: how often which template was answered, by (expected, answered); right ones too.
    """

    samples: int = 0
    exact: int = 0
    verb: int = 0
    objects: int = 0
    unparsable: int = 0
    confusions: Counter[tuple[str, str]] = field(default_factory=Counter)
    verbs: Counter[tuple[str, str]] = field(default_factory=Counter)

    def add(self, expected: str, answer: str, grammar: Grammar = BASIC_GRAMMAR) -> None:
        """Count one answer; an answer outside the grammar is right only if it is the expected text itself."""
        wanted, given = grammar.parsed_or_none(expected), grammar.parsed_or_none(answer)
        verb = objects = exact = answer == expected
        if wanted is not None and given is not None:
            verb = wanted.template == given.template
            objects = _objects(wanted, grammar) == _objects(given, grammar)
            exact = verb and wanted.arguments == given.arguments
        self.samples += 1
        self.exact, self.verb, self.objects = self.exact + exact, self.verb + verb, self.objects + objects
        self.unparsable += given is None and answer != expected
        self.verbs[_verb(wanted), _verb(given)] += 1
        if not exact:
            self.confusions[expected, answer] += 1

    def __add__(self, other: Score) -> Score:
        """Both counted together."""
        numbers = {name: getattr(self, name) + getattr(other, name) for name in ("samples", *MEASURES, "unparsable")}
        return Score(**numbers, confusions=self.confusions + other.confusions, verbs=self.verbs + other.verbs)

    def share(self, measure: str) -> float:
        """The share in 0..1 of answers that a measure counts; 0 where there are none."""
        return getattr(self, measure) / max(1, self.samples)

    def summary(self, confusions: int = 5) -> dict[str, Any]:
        """Shares in 0..1, the 95 % interval of the exact ones, the number of samples, and the commonest mistakes."""
        worst = sorted(self.confusions.items(), key=lambda item: (-item[1], item[0]))[:confusions]
        return {
            "samples": self.samples,
            **{name: self.share(name) for name in (*MEASURES, "unparsable")},
            "interval": list(wilson(self.exact, self.samples)),
            "confusions": [{"expected": pair[0], "answer": pair[1], "count": count} for pair, count in worst],
        }


def macro(scores: Sequence[Score]) -> dict[str, Any]:
    """Average of the shares over tasks, each counting the same, as in table I of the paper."""
    counted = [score for score in scores if score.samples]
    shares = {name: sum(score.share(name) for score in counted) / max(1, len(counted)) for name in MEASURES}
    return {"tasks": len(counted), "samples": sum(score.samples for score in counted), **shares}


def _verb(instruction: Instruction | None) -> str:
    return OUTSIDE if instruction is None else instruction.template


def _objects(instruction: Instruction, grammar: Grammar) -> tuple[str, ...]:
    """The noun phrases, without the pose relative to one."""
    slots = grammar.slots(instruction.template)
    return tuple(text for slot, text in zip(slots, instruction.arguments, strict=True) if slot != "pose")
