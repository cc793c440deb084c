"""A grammar's data, as a YAML file or a dictionary gives it, read and checked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import yaml

from lerobot_llakey.errors import LlakeyError, MissingFileError, said
from lerobot_llakey.grammar_overlap import SLOT, fits_both

LONGEST = 200
"""Characters of the longest instruction of a template, with single spaces."""
MOST_TEMPLATES, MOST_WORDINGS, MOST_POSES = 200, 20, 50
WORD = re.compile(r"[^\W_][\w'-]*")
_NAME = re.compile(r"[a-z]\w{0,60}")
_GRIPPER: dict[str, bool] = {"open": True, "closed": False}
_KEYS = ("templates", "poses", "about_tool_axis", "straight_up")
_MOST_BYTES = 200_000


@dataclass(frozen=True)
class Template:
    """The wordings of one basic action.

    Attributes:
        texts: the canonical wording, then its synonyms; all with the same slots in the same order.
        gripper: the condition hidden in the words: True leaves the gripper open, False closed, None says nothing.
    """

    texts: tuple[str, ...]
    gripper: bool | None = None

    @property
    def slots(self) -> tuple[str, ...]:
        """Names of the arguments, in order."""
        return tuple(SLOT.findall(self.texts[0]))


@dataclass(frozen=True)
class Instruction:
    """One basic action with its arguments, as a grammar reads it.

    Attributes:
        template: its name in the grammar.
        arguments: one text a slot of the template: a pose, else a lower-case noun phrase.
        variant: which wording: 0 is the canonical one.
    """

    template: str
    arguments: tuple[str, ...] = ()
    variant: int = 0


@dataclass(frozen=True)
class Rules:
    """What a grammar file says.

    Attributes:
        templates: by name.
        poses: what ``{pose}`` may be.
        about_tool_axis: templates whose hand turns about, and moves along, its own z axis.
        straight_up: templates whose hand moves straight up.
        joining: words that directly follow a noun phrase in some wording: they mark where a phrase ends.
    """

    templates: Mapping[str, Template]
    poses: tuple[str, ...]
    about_tool_axis: tuple[str, ...]
    straight_up: tuple[str, ...]
    joining: frozenset[str]


NOTHING = Rules({}, (), (), (), frozenset())
"""Of a grammar without templates."""


def read_file(path: Path) -> Any:
    """The data in a YAML file, plain values alone.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it is too long, or no YAML of plain values.
    """
    if not path.is_file():
        raise MissingFileError(f"Expected basic, free or a grammar file, got {str(path)!r}; give one of these.")
    if path.stat().st_size > _MOST_BYTES:
        raise LlakeyError(f"Expected a grammar of at most {_MOST_BYTES} bytes, got {path}; shorten it.")
    try:
        text = path.read_text(encoding="utf-8")
        if any(isinstance(token, yaml.AliasToken) for token in yaml.scan(text)):
            raise LlakeyError(f"Expected a grammar without aliases, got one in {path}; write it out.")
        return yaml.safe_load(text)
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise LlakeyError(f"Expected YAML in {path}, got something else ({said(error, 200)}); correct it.") from error


def read_rules(data: Any, where: str) -> Rules:
    """Check a grammar's data.

    Args:
        data: as YAML reads it.
        where: what an error calls it.

    Raises:
        LlakeyError: naming the template and its fault.
    """
    data = _mapping(data, _KEYS, where)
    named = data.get("templates")
    if not isinstance(named, Mapping) or not 1 <= len(named) <= MOST_TEMPLATES:
        raise LlakeyError(
            f"Expected 1 to {MOST_TEMPLATES} templates in {where}, got {_shown(named)}; list them under 'templates'."
        )
    poses = _texts(data.get("poses", []), f"poses in {where}", MOST_POSES, least=0)
    for pose in poses:
        _check_words(pose.split(), pose, f"poses in {where}")
    for one, other in combinations(poses, 2):
        if f"{other} ".startswith(f"{one} ") or f"{one} ".startswith(f"{other} "):
            raise LlakeyError(
                f"Expected poses in {where} of which none begins with another, got {one!r} and {other!r}; rename one."
            )
    templates = {_name(name, where): _template(name, one, poses, where) for name, one in named.items()}
    roles = {}
    for role in ("about_tool_axis", "straight_up"):
        roles[role] = _texts(data.get(role, []), f"{role} in {where}", MOST_TEMPLATES, least=0)
        if unknown := [name for name in roles[role] if name not in templates]:
            raise LlakeyError(
                f"Expected templates of the grammar for {role} in {where}, got {unknown[0]!r}; pick from "
                f"{', '.join(templates)}."
            )
    wordings = [(name, text) for name, template in templates.items() for text in template.texts]
    joining = frozenset(word for _, text in wordings for slot, word in _followed(text) if slot != "pose")
    for (name, one), (other_name, other) in combinations(wordings, 2):
        if (text := fits_both(one, other, poses, joining)) is not None:
            raise LlakeyError(
                f"Expected one reading of each text in {where}, got templates {name!r} ({one!r}) and {other_name!r} "
                f"({other!r}), which both read {text!r}; reword one."
            )
    return Rules(templates, poses, roles["about_tool_axis"], roles["straight_up"], joining)


def _mapping(data: Any, keys: Sequence[str], where: str) -> Mapping[str, Any]:
    if not isinstance(data, Mapping):
        raise LlakeyError(f"Expected {', '.join(keys)} in {where}, got {_shown(data)}; write them as 'key: value'.")
    if unknown := [key for key in data if key not in keys]:
        raise LlakeyError(f"Expected the keys {', '.join(keys)} in {where}, got {_shown(unknown[0])}; remove it.")
    return data


def _name(name: Any, where: str) -> str:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise LlakeyError(
            f"Expected names of templates in {where} in lower case like 'move_grasp', got {_shown(name)}; rename it."
        )
    return name


def _template(name: str, data: Any, poses: Sequence[str], where: str) -> Template:
    where = f"template {name!r} of {where}"
    data = _mapping(data, ("wordings", "gripper"), where)
    texts = _texts(data.get("wordings"), f"wordings in {where}", MOST_WORDINGS)
    gripper = data.get("gripper")
    if gripper is not None and (not isinstance(gripper, str) or gripper not in _GRIPPER):
        raise LlakeyError(f"Expected gripper open or closed in {where}, got {_shown(gripper)}; leave it out for none.")
    for text in texts:
        _check_words(SLOT.sub(" ", text).split(), text, where, may_be_none=True)
        slots = SLOT.findall(text)
        if len(set(slots)) != len(slots) or slots != SLOT.findall(texts[0]):
            raise LlakeyError(
                f"Expected each wording in {where} to have the slots of {texts[0]!r} once and in its order, got "
                f"{text!r}; reword it."
            )
        if any(SLOT.fullmatch(word) for _, word in _followed(text)):
            raise LlakeyError(f"Expected a word between two slots in {where}, got {text!r}; add one.")
        if "pose" in slots and not poses:
            raise LlakeyError(f"Expected poses for {{pose}} in {where}, got none; list them under 'poses'.")
    return Template(texts, None if gripper is None else _GRIPPER[gripper])


def _texts(data: Any, what: str, most: int, least: int = 1) -> tuple[str, ...]:
    """A list of different texts in lower case with single spaces."""
    if not isinstance(data, list) or not least <= len(data) <= most:
        raise LlakeyError(f"Expected a list of {least} to {most} {what}, got {_shown(data)}; write them in a list.")
    for text in data:
        if not isinstance(text, str) or not text or text != " ".join(text.split()).lower() or len(text) > LONGEST:
            raise LlakeyError(
                f"Expected {what} in lower case with single spaces, at most {LONGEST} characters, got {_shown(text)}; "
                "reword it."
            )
    if repeated := [text for text in data if data.count(text) > 1]:
        raise LlakeyError(f"Expected different {what}, got {repeated[0]!r} twice; remove one.")
    return tuple(data)


def _check_words(words: Sequence[str], text: str, where: str, may_be_none: bool = False) -> None:
    if not (words or may_be_none) or not all(WORD.fullmatch(word) for word in words):
        raise LlakeyError(
            f"Expected plain words and slots like {{thing}} in {where}, got {text!r}; leave other signs out."
        )


def _followed(text: str) -> list[tuple[str, str]]:
    """Each slot of a wording with the word or slot right after it."""
    words = text.split()
    slots = [SLOT.fullmatch(word) for word in words]
    return [(slot[1], after) for slot, after in zip(slots, words[1:], strict=False) if slot]


def _shown(value: Any) -> str:
    text = repr(value)
    return "none" if value is None else text if len(text) <= 80 else f"{text[:77]}..."


def phrase_problem(slot: str, argument: str, joining: frozenset[str]) -> str | None:
    """What is wrong with a noun phrase, in one sentence, or None."""
    words = argument.split()
    if not words or argument != " ".join(words).lower() or not all(map(WORD.fullmatch, words)):
        return (
            f"Expected a noun phrase of lower-case words with single spaces for {slot!r}, got {argument!r}; "
            "write it like 'the red block'."
        )
    held = [word for word in words if word in joining]
    if held:
        return (
            f"Expected a noun phrase without the joining words {', '.join(sorted(joining))} for {slot!r}, "
            f"got {argument!r}; name the thing without {held[0]!r}."
        )
    return None
