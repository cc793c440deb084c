"""The command policy's prompt, as in the paper.

Source: section III-C and figure 4 of the paper. The system message comes first, then each camera's description
followed by its image, then the request. The sentences about the robot's state and the previous instruction are
extensions of this project.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lerobot_llakey.grammar import Grammar

SYSTEM_MESSAGE = (
    "You are a helpful language and vision assistant. You are able to understand the visual content that the user "
    "provides and assist the user with a variety of tasks using natural language."
)
STOP = "<next goal>"
"""Ends every answer."""

TASK_BEGIN = "Task:"
TASK_END = ", please instruct the robotic arm's next action based on the current images."
STATE_BEGIN = "Robot state:"
PREVIOUS_BEGIN = "Previous instruction:"
NO_PREVIOUS = "none."

ANSWER_RULE = (
    "Name the one basic action that the robotic arm has to do next: repeat the previous instruction while it is "
    "unfinished, else say what comes after it. Answer with one line of lower-case words and nothing else."
)
"""For models that were not trained on these answers; not in the paper."""

_DESCRIPTIONS: dict[str, str] = {
    "front": "Image in front of the robotic arm:",
    "left_shoulder": "Image from the left shoulder of the robotic arm:",
    "right_shoulder": "Image from the right shoulder of the robotic arm:",
    "wrist": "Image from the wrist of the robotic arm:",
}


def describe_camera(camera: str) -> str:
    """The short description before a camera's image."""
    return _DESCRIPTIONS.get(camera, f"Image from the {camera.replace('_', ' ')} camera:")


def sentences(cameras: Sequence[str], has_state: bool = False) -> list[str]:
    """Every constant sentence of a prompt; the small vocabulary has one token for each.

    Args:
        cameras: their names.
        has_state: whether the prompt contains the robot's state.
    """
    constants = (TASK_BEGIN, TASK_END, PREVIOUS_BEGIN, NO_PREVIOUS, *([STATE_BEGIN] if has_state else []))
    return [SYSTEM_MESSAGE, *map(describe_camera, cameras), *constants]


def answer_forms(grammar: Grammar) -> str:
    """Guidance about answers for an untrained model: the templates of basic actions."""
    if grammar.is_free:
        return ANSWER_RULE
    forms = [f"- {template.texts[0]}" for template in grammar.templates.values()]
    names = list(dict.fromkeys(slot for template in grammar.templates.values() for slot in template.slots))
    phrases = [f"{{{name}}}" for name in names if name != "pose"]
    poses = f"{{pose}} is one of: {', '.join(grammar.poses)}; " if "pose" in names else ""
    what = " and ".join(filter(None, (", ".join(phrases[:-1]), *phrases[-1:])))
    slots = f'Here {poses}{what} are short noun phrases such as "the red block".' if phrases else ""
    return "\n".join([f"{ANSWER_RULE} It has one of these forms:", *forms, slots])


def answer_list(known: Sequence[str]) -> str:
    """Guidance about answers for an untrained model: all known answers."""
    return "\n".join([f"{ANSWER_RULE} It is one of these:", *(f"- {text}" for text in known)])


@dataclass(frozen=True)
class Prompt:
    """One request to the command policy.

    Attributes:
        cameras: their names, in the order of their images.
        task: the skill instruction.
        previous: the instruction last commanded, "" at the start of an episode, None to leave its sentence out (the
            paper's form).
        state: the robot's state as numbers, None to leave its sentence out (the paper's form).
    """

    cameras: tuple[str, ...]
    task: str
    previous: str | None = None
    state: str | None = None

    @property
    def opening(self) -> str:
        """The system message, which comes first."""
        return SYSTEM_MESSAGE

    @property
    def descriptions(self) -> tuple[str, ...]:
        """The description before each camera's image, in order."""
        return tuple(map(describe_camera, self.cameras))

    @property
    def request(self) -> tuple[str, ...]:
        """The text after the last image, in pieces: constant sentences separate from variable text."""
        state = () if self.state is None else (STATE_BEGIN, self.state)
        before = () if self.previous is None else (PREVIOUS_BEGIN, self.previous or NO_PREVIOUS)
        return (TASK_BEGIN, self.task, TASK_END, *state, *before)

    @property
    def request_text(self) -> str:
        """The text after the last image."""
        begin, task, end, *rest = self.request
        return " ".join((begin, f"{task}{end}", *rest))

    @property
    def conversation(self) -> list[dict[str, Any]]:
        """The prompt as the messages of a chat template, images as placeholders in their places."""
        pieces: list[dict[str, str]] = []
        for index, description in enumerate(self.descriptions):
            line = "\n" if index else ""
            pieces += [{"type": "text", "text": f"{line}{description} "}, {"type": "image"}]
        pieces.append({"type": "text", "text": f"\n{self.request_text}"})
        system = [{"type": "text", "text": self.opening}]
        return [{"role": "system", "content": system}, {"role": "user", "content": pieces}]

    def text(self, image_token: str, template: str = "{system} USER: {request} ASSISTANT:") -> str:
        """The whole prompt as one text, with ``image_token`` where an image goes.

        Args:
            image_token: the placeholder that a processor replaces by an image's tokens.
            template: the language model's own conversation form, with the slots ``{system}`` and ``{request}``.
        """
        shown = [f"{description} {image_token}" for description in self.descriptions]
        return template.format(system=self.opening, request="\n".join([*shown, self.request_text]))
