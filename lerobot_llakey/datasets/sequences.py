"""Which instruction leads to each keyframe of a demonstration: sequences by task, from a YAML file.

RLBench's demonstrations (``llakey convert``) and anyone's recordings (``llakey annotate``) take theirs from such files.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.grammar import Grammar

SHIPPED = Path(__file__).parent.parent / "grammars" / "rlbench_instructions.yaml"
"""The instructions of the five tasks that are RLBench's and the simulator's."""
YAML_SUFFIXES = (".yaml", ".yml")
_SLOT = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class TaskInstructions:
    """Of one task.

    Attributes:
        task: its name.
        descriptions: how a skill instruction names what varies.
        sequences: for each way to do the task one instruction a keyframe.
        grammar: of the instructions.
    """

    task: str
    descriptions: tuple[str, ...]
    sequences: tuple[tuple[str, ...], ...]
    grammar: Grammar

    def variables(self, skills: Sequence[str]) -> dict[str, str]:
        """What varies, out of an episode's skill instructions.

        Raises:
            LlakeyError: if none of them reads like one of the descriptions.
        """
        if (found := self._read(skills)) is not None:
            return found
        raise LlakeyError(
            f"Expected a skill instruction of {self.task} such as {self.descriptions[0]!r}, got {list(skills)!r:.200}; "
            "add its form to the descriptions in a file for --instructions."
        )

    def describes(self, skill: str) -> bool:
        """Whether a skill instruction reads like one of the descriptions."""
        return self._read([skill]) is not None

    def _read(self, skills: Sequence[str]) -> dict[str, str] | None:
        for pattern in self.descriptions:
            for skill in skills:
                if match := _pattern(pattern).fullmatch(" ".join(skill.lower().split())):
                    return match.groupdict()
        return None

    def fitting(
        self, skills: Sequence[str], gripper_open: Sequence[bool], *, open_at_first: bool = True, by_count: bool = False
    ) -> tuple[int, list[str]] | None:
        """The instructions of an episode: of the first sequence with as many as keyframes, and the gripper's changes.

        Args:
            skills: the episode's skill instructions.
            gripper_open: whether the gripper is open at each keyframe.
            open_at_first: whether it is open in the episode's first frame.
            by_count: whether to look at the number of keyframes alone, as where there is no gripper; free text, whose
                words imply nothing, is always chosen so.

        Returns:
            The number of the sequence and its instructions, one a keyframe; None if no sequence fits the gripper.

        Raises:
            LlakeyError: if the skill instructions do not tell what varies, or an instruction is outside the grammar.
        """
        known = self.variables(skills)
        for number, sequence in enumerate(self.sequences):
            texts = [text.format(**known) for text in sequence]
            counts = (by_count or self.grammar.is_free) and len(texts) == len(gripper_open)
            if counts or _openness(texts, self.grammar, open_at_first) == list(gripper_open):
                return number, texts
        return None

    def patterns(self, open_at_first: bool = True) -> str:
        """The gripper at the keyframes of each sequence, as an error shows it."""
        return " or ".join(shown(_openness(sequence, self.grammar, open_at_first)) for sequence in self.sequences)


def shown(gripper_open: Sequence[bool]) -> str:
    """The gripper at each keyframe in letters: o open, c closed."""
    return "".join("o" if opened else "c" for opened in gripper_open)


def read_sequences(path: Path, grammar: Grammar) -> dict[str, TaskInstructions]:
    """Read instructions by task.

    Args:
        path: of the YAML file; :data:`SHIPPED` shows its form.
        grammar: of the instructions.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: naming the task that lacks something, or whose instruction is outside the grammar.
    """
    with reading(path, "YAML file of instructions"):
        content: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, Mapping) or not content:
        raise LlakeyError(f"Expected tasks with descriptions and sequences in {path}, got {content!r:.80}; write them.")
    return {str(task): _task(str(task), entry, grammar, path) for task, entry in content.items()}


def _task(task: str, entry: Any, grammar: Grammar, path: Path) -> TaskInstructions:
    given = entry if isinstance(entry, Mapping) else {}
    descriptions, sequences = given.get("descriptions"), given.get("sequences")
    if not _texts(descriptions) or not isinstance(sequences, list) or not sequences or not all(map(_texts, sequences)):
        raise LlakeyError(
            f"Expected lists of texts as descriptions and sequences of {task} in {path}, got {entry!r:.120}; "
            "complete them."
        )
    assert isinstance(descriptions, list)
    for number, sequence in enumerate(sequences):
        for text in sequence:
            slots = set(_SLOT.findall(text))
            if lacking := [form for form in descriptions if not slots <= set(_SLOT.findall(form))]:
                raise LlakeyError(
                    f"Expected {', '.join(sorted(slots))} in each description of {task} in {path}, as sequence "
                    f"{number} needs it, got {lacking[0]!r}; name it there."
                )
            grammar.parse(_SLOT.sub("red", text))
    taken = tuple(tuple(" ".join(text.split()) for text in sequence) for sequence in sequences)
    return TaskInstructions(task, tuple(descriptions), taken, grammar)


def _texts(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(text, str) and text.strip() for text in value)


def _pattern(description: str) -> re.Pattern[str]:
    """A description as an expression: a slot takes any words, and the same ones wherever it stands again."""
    seen: set[str] = set()

    def group(slot: re.Match[str]) -> str:
        again = slot[1] in seen
        seen.add(slot[1])
        return f"(?P={slot[1]})" if again else f"(?P<{slot[1]}>[^,]+?)"

    pieces = re.split(r"(\{\w+\})", " ".join(description.lower().split()))
    return re.compile(
        "".join(_SLOT.sub(group, piece) if _SLOT.fullmatch(piece) else re.escape(piece) for piece in pieces)
    )


def _openness(texts: Sequence[str], grammar: Grammar, open_at_first: bool = True) -> list[bool]:
    """Whether the gripper is open after each instruction, from the words alone."""
    opened = [open_at_first]
    for text in texts:
        implied = grammar.gripper_implied(_SLOT.sub("red", text))
        opened.append(opened[-1] if implied is None else implied)
    return opened[1:]
