"""Grammars: which texts are instructions, and what they imply. A grammar is data: a YAML file, or free text.

A grammar of templates ("grasp {thing}") reads a text as a template filled with a pose out of its list and noun phrases
("the red block"). Noun phrases may not hold the words that join templates ("to", "and", "in", ...), and loading refuses
templates that could read the same text, so every text has at most one reading and ``parse(render(i)) == i``. The
grammar ``free`` reads any sentence, as it is. ``docs/words.md`` says how to write one.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lerobot_llakey.errors import LlakeyError, said
from lerobot_llakey.grammar_data import LONGEST, NOTHING, Instruction, Template, phrase_problem, read_file, read_rules
from lerobot_llakey.grammar_overlap import SLOT
from lerobot_llakey.schema import GRAMMAR_INFO
from lerobot_llakey.sentences import SENTENCE, read_sentence, shortened

BASIC, FREE = "basic", "free"
"""Names of the grammars that come with the package."""
_BASIC_FILE = Path(__file__).parent / "grammars" / "basic.yaml"


class Grammar:
    """Which texts are instructions; made by :meth:`load` or :meth:`from_data`.

    Args:
        data: :data:`BASIC`, :data:`FREE`, or the contents of a grammar file.
        where: what an error calls it.

    Attributes:
        is_free: whether any sentence is an instruction.
        templates: every basic action by name; none where any sentence is.
        poses: what ``{pose}`` may be.
        joining: words that a noun phrase may not hold.
        about_tool_axis, straight_up: templates whose hand turns about its own z axis, and that moves straight up.

    Raises:
        LlakeyError: in one sentence naming the template and the fault.
    """

    def __init__(self, data: Any, where: str = "the grammar") -> None:
        self._data = data
        self.is_free = data == FREE
        contents = read_file(_BASIC_FILE) if data == BASIC else data
        rules = NOTHING if self.is_free else read_rules(contents, where)
        self.templates: Mapping[str, Template] = rules.templates
        self.poses, self.joining = rules.poses, rules.joining
        self.about_tool_axis, self.straight_up = rules.about_tool_axis, rules.straight_up
        groups = {"pose": f"({'|'.join(map(re.escape, self.poses))})"}
        self._patterns = tuple(
            (name, variant, re.compile(SLOT.sub(lambda slot: groups.get(slot[1], "(.+?)"), text)))
            for name, template in self.templates.items()
            for variant, text in enumerate(template.texts)
        )
        self._read = lru_cache(maxsize=4096)(self._look_up)

    @staticmethod
    def load(source: str | Path) -> Grammar:
        """A grammar by its name, ``basic`` or ``free``, or from a YAML file.

        Raises:
            MissingFileError: if there is no such file.
            LlakeyError: if it is no grammar, naming the template and the fault.
        """
        if source in (BASIC, FREE):
            return Grammar.from_data(source)
        return Grammar(read_file(Path(source)), str(source))

    @staticmethod
    def from_data(data: Any) -> Grammar:
        """A grammar from what :meth:`to_data` gave, None for ``basic``.

        Raises:
            LlakeyError: if it is no grammar, naming the template and the fault.
        """
        try:
            text = json.dumps(BASIC if data is None else data)
        except (TypeError, ValueError) as error:
            raise LlakeyError(f"Expected a grammar's data, got {said(error, 200)}; correct it.") from error
        return _from_text(text)

    def to_data(self) -> str | dict[str, Any]:
        """The whole grammar as plain data for JSON, or its name."""
        data: str | dict[str, Any] = self._data
        return data

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Grammar) and self._data == other._data

    def __hash__(self) -> int:
        return hash(json.dumps(self._data))

    def __reduce__(self) -> Any:
        return Grammar.from_data, (self._data,)

    @property
    def name(self) -> str:
        """What a sentence calls it."""
        return (
            f"the grammar {self._data!r}"
            if isinstance(self._data, str)
            else "the dataset's or checkpoint's own grammar"
        )

    def slots(self, template: str) -> tuple[str, ...]:
        """Names of a template's arguments."""
        return (SENTENCE,) if self.is_free else self.templates[template].slots

    def instruct(self, template: str, *arguments: str) -> str:
        """The canonical text of a template filled with arguments.

        Raises:
            LlakeyError: if the template is unknown or the arguments do not fit it.
        """
        return self.render(Instruction(template, arguments))

    def render(self, instruction: Instruction) -> str:
        """The text of an instruction.

        Raises:
            LlakeyError: if the template, the variant, the arguments or their number are not in the grammar.
        """
        if self.is_free:
            return self.canonical(" ".join(instruction.arguments))
        template = self.templates.get(instruction.template)
        if template is None:
            names = ", ".join(self.templates)
            raise LlakeyError(f"Expected a template out of {names}, got {instruction.template!r}; pick one.")
        if not 0 <= instruction.variant < len(template.texts):
            raise LlakeyError(
                f"Expected a variant below {len(template.texts)} of template {instruction.template!r}, got "
                f"{instruction.variant}; use 0."
            )
        if len(instruction.arguments) != len(template.slots):
            raise LlakeyError(
                f"Expected the arguments {template.slots} of template {instruction.template!r}, got "
                f"{instruction.arguments}; give one for each."
            )
        filled = dict(zip(template.slots, instruction.arguments, strict=True))
        for slot, argument in filled.items():
            if problem := self._problem(slot, argument):
                raise LlakeyError(problem)
        text = template.texts[instruction.variant].format(**filled)
        longest = self._longest(instruction)
        if longest > LONGEST:
            raise LlakeyError(
                f"Expected an instruction of at most {LONGEST} characters, got one of {longest}; name the things in "
                "fewer words."
            )
        return text

    def parse(self, text: str) -> Instruction:
        """The only reading of a text; letter case, repeated spaces and a final full stop do not matter to templates.

        Raises:
            LlakeyError: if the text is no instruction of the grammar.
        """
        if self.is_free:
            return Instruction(SENTENCE, (read_sentence(text),))
        plain = " ".join(text.split(maxsplit=LONGEST)).removesuffix(".")
        instruction = self._read(plain.lower()) if len(plain) <= LONGEST else None
        if instruction is None:
            raise LlakeyError(
                f"Expected a basic action of {self.name}, such as {next(iter(self.templates.values())).texts[0]!r}, "
                f"got {shortened(text)}; reword it, add a template, or choose --grammar={FREE}."
            )
        return instruction

    def parsed_or_none(self, text: str) -> Instruction | None:
        """What :meth:`parse` gives, None for a text outside the grammar; never raises."""
        try:
            return self.parse(text)
        except LlakeyError:
            return None

    def is_parsable(self, text: str) -> bool:
        """Whether a text is an instruction of the grammar."""
        return self.parsed_or_none(text) is not None

    def canonical(self, text: str | Instruction) -> str:
        """The same instruction, read already or not, in its canonical wording; a free text with single spaces.

        Raises:
            LlakeyError: if the text is no instruction of the grammar.
        """
        instruction = self.parse(text) if isinstance(text, str) else text
        return instruction.arguments[0] if self.is_free else self.instruct(instruction.template, *instruction.arguments)

    def paraphrase(self, text: str, rng: np.random.Generator) -> str:
        """The same instruction in a wording drawn uniformly from those of its template; a free text as it is.

        Raises:
            LlakeyError: if the text is no instruction of the grammar.
        """
        instruction = self.parse(text)
        if self.is_free:
            return text
        variant = int(rng.integers(len(self.templates[instruction.template].texts)))
        return self.render(Instruction(instruction.template, instruction.arguments, variant))

    def gripper_implied(self, text: str | Instruction) -> bool | None:
        """The gripper condition in the words: True open, False closed, None if nothing is implied; never raises."""
        instruction = self.parsed_or_none(text) if isinstance(text, str) else text
        return None if instruction is None or self.is_free else self.templates[instruction.template].gripper

    def _longest(self, instruction: Instruction) -> int:
        """Characters of the longest wording."""
        filled = dict(zip(self.slots(instruction.template), instruction.arguments, strict=True))
        return max(len(text.format(**filled)) for text in self.templates[instruction.template].texts)

    def _problem(self, slot: str, argument: str) -> str | None:
        """What is wrong with an argument, in one sentence, or None."""
        if slot == "pose":
            poses = ", ".join(self.poses)
            return None if argument in self.poses else f"Expected a pose out of {poses}, got {argument!r}; pick one."
        return phrase_problem(slot, argument, self.joining)

    def _look_up(self, plain: str) -> Instruction | None:
        """The reading of a text in lower case with single spaces, None where there is none."""
        for name, variant, pattern in self._patterns:
            match = pattern.fullmatch(plain)
            if match and not any(map(self._problem, self.templates[name].slots, match.groups())):
                instruction = Instruction(name, match.groups(), variant)
                return instruction if self._longest(instruction) <= LONGEST else None
        return None


@lru_cache(maxsize=64)
def _from_text(text: str) -> Grammar:
    return Grammar(json.loads(text))


def of_features(features: Mapping[str, Any], key: str) -> Grammar:
    """The grammar of a dataset's texts, ``basic`` where it names none.

    Args:
        features: as ``info.json`` describes them.
        key: of the instruction feature.
    """
    return Grammar.from_data(((features.get(key) or {}).get("info") or {}).get(GRAMMAR_INFO))
