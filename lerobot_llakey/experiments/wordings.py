"""The wordings of figure 1 of the paper: one skill, two action sequences, and verbs that name them or do not.

Bulbs of ``put_bulb`` stand loose, or are screwed in and must be unscrewed first. Policies learn it with *one* wording
for both sequences or with *two*, and are tested with the wording that they know and with others.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED

TASK_NAME = "put_bulb"
PUT = "put the {bulb} light bulb in the {box} box"
UNSCREW = "unscrew the {bulb} light bulb and put it into the {box} box"
TAKE = "take the {bulb} light bulb and it into the {box} box"
BARE = "{bulb} light bulb, {box} box"
_SKILL = re.compile(r"put the (?P<bulb>\w+) light bulb in the (?P<box>\w+) box")

TRAININGS: dict[str, dict[int, str]] = {
    "one": {LOOSE: PUT, SCREWED: PUT},
    "two": {LOOSE: PUT, SCREWED: UNSCREW},
}
"""Wording of each sequence in training."""
TESTS: dict[str, str] = {
    "as_trained": "as trained",
    "swapped": "the other sequence's verbs",
    "replaced": "verbs replaced",
    "removed": "verbs removed",
}
"""Wordings tested. Replaced is the paper's "take ... and it into ...", removed its "{color} light bulb, ..."."""
PAPER: dict[tuple[str, str], float] = {
    ("one", "as_trained"): 60,
    ("one", "removed"): 64,
    ("two", "as_trained"): 60,
    ("two", "replaced"): 72,
}
"""The paper's success in percent by training and test (section I); its 72 % is of verbs "replaced or removed"."""


def reword(description: str, template: str) -> str:
    """A skill instruction of ``put_bulb`` in another wording.

    Raises:
        LlakeyError: if it is no skill instruction of that task.
    """
    found = _SKILL.fullmatch(description)
    if found is None:
        raise LlakeyError(f"Expected a skill instruction like {PUT!r}, got {description!r}; use put_bulb.")
    return template.format(**found.groupdict())


def trained_wording(training: str, description: str, sequence: int) -> str:
    """How a skill instruction is worded in training.

    Args:
        training: "one" or "two" wordings.
        description: the simulator's skill instruction.
        sequence: that the scene asks for.
    """
    return reword(description, TRAININGS[training][sequence])


@dataclass(frozen=True)
class TestedWording:
    """How a skill instruction is worded in a test.

    Swapped tells to unscrew what stands loose, and merely to put away what is screwed in, whatever was trained.

    Attributes:
        training: "one" or "two" wordings.
        test: out of TESTS.
    """

    training: str
    test: str

    def __call__(self, description: str, sequence: int) -> str:
        """The simulator's skill instruction, of a scene that asks for an action sequence, in these words."""
        if self.test == "as_trained":
            return trained_wording(self.training, description, sequence)
        if self.test == "swapped":
            return reword(description, TRAININGS["two"][SCREWED if sequence == LOOSE else LOOSE])
        return reword(description, TAKE if self.test == "replaced" else BARE)
