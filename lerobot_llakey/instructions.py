"""The grammar of basic actions: sixteen templates, each with at most one synonym, rendered and parsed here alone.

An instruction is a template filled with a pose out of ``POSES`` and noun phrases ("the red block"). Noun phrases may
not hold the words that join templates ("to", "and", "in", ...), so every text has at most one reading and
``parse(render(instruction)) == instruction``. A text longer than ``LONGEST`` is none: people and models may write
anything, and looking for a template in a text takes the square of its length. Source: section IV-B of the paper, where
sixteen templates are named.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from string import Formatter

import numpy as np

from lerobot_llakey.errors import LlakeyError

POSES: tuple[str, ...] = ("top", "front", "back", "left side", "right side", "bottom")
"""What may stand for ``{pose}``: where to move, relative to a thing."""
LONGEST = 200
"""Characters of the longest instruction, with single spaces."""


@dataclass(frozen=True)
class Template:
    """The wordings of one basic action.

    Attributes:
        texts: the canonical wording, then its synonym if there is one; all with the same slots in the same order.
        gripper: the condition hidden in the words: True leaves the gripper open, False closed, None says nothing.
    """

    texts: tuple[str, ...]
    gripper: bool | None = None

    @property
    def slots(self) -> tuple[str, ...]:
        """Names of the arguments, in order."""
        return tuple(slot for _, slot, _, _ in Formatter().parse(self.texts[0]) if slot is not None)


TEMPLATES: dict[str, Template] = {
    "move": Template(("move to the {pose} of {thing}", "go to the {pose} of {thing}")),
    "rotate": Template(("rotate {thing} to {target}", "turn {thing} to {target}")),
    "grasp": Template(("grasp {thing}", "grab {thing}"), gripper=False),
    "release": Template(("release {thing}", "let go of {thing}"), gripper=True),
    "move_grasp": Template(
        ("move to the {pose} of {thing} and grasp it", "go to the {pose} of {thing} and grab it"), gripper=False
    ),
    "move_release": Template(
        ("move to the {pose} of {thing} and release {held}", "go to the {pose} of {thing} and let go of {held}"),
        gripper=True,
    ),
    "rotate_release": Template(
        ("rotate {thing} to {target} and release it", "turn {thing} to {target} and let go of it"), gripper=True
    ),
    "slide": Template(("slide {thing} to {target}", "push {thing} to {target}")),
    "screw_in": Template(("screw {thing} in", "twist {thing} in")),
    "screw_out": Template(("screw {thing} out", "twist {thing} out")),
    "align": Template(("align downward with {thing}", "line up downward with {thing}")),
    "raise": Template(("raise the robotic arm", "lift the robotic arm")),
    "pull_out": Template(("pull {thing} out", "draw {thing} out")),
    "insert": Template(("insert {thing} into {target}", "put {thing} into {target}")),
    "place": Template(("place {thing} on {target}", "put {thing} on {target}")),
    "pull_open": Template(("pull {thing} open", "draw {thing} open")),
}
"""Every basic action by name; a new one is one more line here."""


def _joining_words() -> frozenset[str]:
    """The words that directly follow a noun phrase in some template: they mark where a phrase ends."""
    texts = [text for template in TEMPLATES.values() for text in template.texts]
    return frozenset(word for text in texts for slot, word in re.findall(r"\{(\w+)\} (\w+)", text) if slot != "pose")


JOINING_WORDS = _joining_words()
_WORD = re.compile(r"[^\W_][\w'-]*")


@dataclass(frozen=True)
class Instruction:
    """One basic action with its arguments.

    Attributes:
        template: a key of ``TEMPLATES``.
        arguments: one text a slot of the template: a pose out of ``POSES``, else a lower-case noun phrase.
        variant: which wording: 0 is the canonical one, 1 its synonym.

    Raises:
        LlakeyError: if the template, the variant, the number of arguments or one of them is not in the grammar.
    """

    template: str
    arguments: tuple[str, ...] = ()
    variant: int = 0

    def __post_init__(self) -> None:
        if self.template not in TEMPLATES:
            raise LlakeyError(f"Expected a template out of {', '.join(TEMPLATES)}, got {self.template!r}; pick one.")
        template = TEMPLATES[self.template]
        if not 0 <= self.variant < len(template.texts):
            raise LlakeyError(
                f"Expected a variant below {len(template.texts)} of template {self.template!r}, got {self.variant}; "
                "use 0."
            )
        if len(self.arguments) != len(template.slots):
            raise LlakeyError(
                f"Expected the arguments {template.slots} of template {self.template!r}, got {self.arguments}; "
                "give one for each."
            )
        for slot, argument in zip(template.slots, self.arguments, strict=True):
            problem = _problem(slot, argument)
            if problem:
                raise LlakeyError(problem)
        if len(render(self)) > LONGEST:
            raise LlakeyError(
                f"Expected an instruction of at most {LONGEST} characters, got one of {len(render(self))}; name the "
                "things in fewer words."
            )


def _problem(slot: str, argument: str) -> str | None:
    """What is wrong with an argument, in one sentence, or None."""
    if slot == "pose":
        return None if argument in POSES else f"Expected a pose out of {', '.join(POSES)}, got {argument!r}; pick one."
    words = argument.split()
    if not words or argument != " ".join(words).lower() or not all(_WORD.fullmatch(word) for word in words):
        return (
            f"Expected a noun phrase of lower-case words with single spaces for {slot!r}, got {argument!r}; "
            "write it like 'the red block'."
        )
    joining = [word for word in words if word in JOINING_WORDS]
    if joining:
        return (
            f"Expected a noun phrase without the joining words {', '.join(sorted(JOINING_WORDS))} for {slot!r}, "
            f"got {argument!r}; name the thing without {joining[0]!r}."
        )
    return None


def _pattern(text: str) -> re.Pattern[str]:
    groups = {"pose": f"({'|'.join(POSES)})"}
    return re.compile(re.sub(r"\{(\w+)\}", lambda slot: groups.get(slot.group(1), "(.+?)"), text))


_PATTERNS: tuple[tuple[str, int, re.Pattern[str]], ...] = tuple(
    (name, variant, _pattern(text))
    for name, template in TEMPLATES.items()
    for variant, text in enumerate(template.texts)
)


def render(instruction: Instruction) -> str:
    """The text of an instruction."""
    template = TEMPLATES[instruction.template]
    return template.texts[instruction.variant].format(**dict(zip(template.slots, instruction.arguments, strict=True)))


def parse(text: str) -> Instruction:
    """The only reading of a text; letter case, repeated spaces and a final full stop do not matter.

    Raises:
        LlakeyError: if the text is no instruction of the grammar.
    """
    plain = " ".join(text.split(maxsplit=LONGEST)).removesuffix(".")
    instruction = _read(plain.lower()) if len(plain) <= LONGEST else None
    if instruction is None:
        raise LlakeyError(
            f"Expected a basic action such as 'grasp the red block', got {shortened(text)}; see instructions.TEMPLATES."
        )
    return instruction


@lru_cache(maxsize=4096)
def _read(plain: str) -> Instruction | None:
    """The reading of a text in lower case with single spaces, None where there is none."""
    for name, variant, pattern in _PATTERNS:
        match = pattern.fullmatch(plain)
        if match and not any(map(_problem, TEMPLATES[name].slots, match.groups())):
            return Instruction(name, match.groups(), variant)
    return None


def shortened(text: str) -> str:
    """A text as an error quotes it: the beginning of a long one, with its length."""
    return repr(text) if len(text) <= LONGEST else f"{text[:LONGEST]!r}... ({len(text)} characters)"


def parsed_or_none(text: str) -> Instruction | None:
    """What :func:`parse` gives, None for a text outside the grammar; never raises."""
    try:
        return parse(text)
    except ValueError:
        return None


def is_parsable(text: str) -> bool:
    """Whether a text is an instruction of the grammar."""
    return parsed_or_none(text) is not None


def instruct(template: str, *arguments: str) -> str:
    """The canonical text of a template filled with arguments.

    Raises:
        LlakeyError: if the template is unknown or the arguments do not fit it.
    """
    return render(Instruction(template, arguments))


def gripper_implied(text: str) -> bool | None:
    """The gripper condition hidden in the words: True open, False closed, None if nothing is implied; never raises."""
    instruction = parsed_or_none(text)
    return None if instruction is None else TEMPLATES[instruction.template].gripper


def canonical(text: str) -> str:
    """The same instruction in its canonical wording.

    Raises:
        LlakeyError: if the text is no instruction of the grammar.
    """
    instruction = parse(text)
    return render(Instruction(instruction.template, instruction.arguments))


def paraphrase(text: str, rng: np.random.Generator) -> str:
    """The same instruction in a wording drawn uniformly from those of its template.

    Raises:
        LlakeyError: if the text is no instruction of the grammar.
    """
    instruction = parse(text)
    variant = int(rng.integers(len(TEMPLATES[instruction.template].texts)))
    return render(Instruction(instruction.template, instruction.arguments, variant))
