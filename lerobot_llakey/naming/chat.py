"""A chat model names the objects of a recording's actions; verbs and directions it is told, from proprioception."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lerobot.datasets.lerobot_dataset import LeRobotDataset
from tqdm import tqdm

from lerobot_llakey import schema
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hand import hand_columns
from lerobot_llakey.hints import nearest_forms
from lerobot_llakey.naming.motion_words import motion_words
from lerobot_llakey.policies.command.chat.client import ChatClient
from lerobot_llakey.policies.command.chat.messages import Message, data_url
from lerobot_llakey.policies.command.chat.settings import ChatSettings, check_address
from lerobot_llakey.policies.command.prompt import answer_forms

CHAT = "chat"
"""What ``--instructions`` says for them."""
OPTIONS = "--chat."
"""How an error begins the name of an option."""
_ATTEMPTS = 3
"""Answers to a question: what does not fit is asked again, with the reason."""
_OPENING = (
    "You label a recording of a robot arm. A skill is a series of basic actions; each ends at a keyframe. You are "
    "given pictures of the frames where one action begins and where it ends, and what the hand did in between, which "
    "the robot measured. Say which basic action it was. Name the object that it is about as you see it, and the same "
    "object always in the same words."
)


@dataclass
class ChatOptions:
    """Options of the chat model that names a recording's actions.

    Attributes:
        model: its name at the server.
        base_url: address of the server, such as http://127.0.0.1:8000/v1; by default OpenAI's own.
        api_key_env: environment variable with the key.
        temperature: of sampling; None leaves it to the server.
        max_tokens: longest answer.
        timeout_s: seconds for an answer.
        max_parallel: questions in flight at once, of different episodes.
    """

    model: str | None = None
    base_url: str | None = None
    api_key_env: str = "OPENAI_API_KEY"
    temperature: float | None = 0.0
    max_tokens: int = 256
    timeout_s: float = 60.0
    max_parallel: int = 4


@dataclass
class _Asked:
    """An episode on the way: what was answered, and what is asked next."""

    episode: FoundKeyframes
    frames: tuple[int, ...]
    texts: list[str]
    refused: list[tuple[str, str]]

    @property
    def done(self) -> bool:
        return len(self.texts) == len(self.episode.keyframes)


def from_chat(
    source: LeRobotDataset, found: Sequence[FoundKeyframes], options: ChatOptions, grammar: Grammar
) -> dict[int, list[str]]:
    """Ask a chat model for the instruction of each segment, one after the other within an episode.

    An answer outside the grammar, or one that leaves the gripper otherwise than it was, is asked for again with the
    reason; after three such answers the instruction stays empty.

    Args:
        source: the recordings, with pictures.
        found: their keyframes.
        options: which model.
        grammar: of the answers.

    Raises:
        LlakeyError: if there are no cameras, no model is named, or the server cannot be reached or refuses.
    """
    cameras = schema.cameras_of(source.features)
    if not cameras:
        raise LlakeyError(
            f"Expected pictures in {source.repo_id} to show to a chat model, got none; give a file with --instructions."
        )
    check_address(options.base_url, options.model, OPTIONS)
    settings = ChatSettings(
        api_key_env=options.api_key_env,
        temperature=options.temperature,
        timeout_s=options.timeout_s,
        max_parallel=options.max_parallel,
        image_format="jpeg",
    )
    client = ChatClient(options.base_url, str(options.model), settings, options.max_tokens, grammar, options=OPTIONS)
    starts = source.meta.episodes["dataset_from_index"]
    asked = [_Asked(one, tuple(int(starts[one.episode]) + at for at in (0, *one.keyframes)), [], []) for one in found]
    with tqdm(total=sum(len(one.keyframes) for one in found), desc="name", unit="action") as bar:
        while waiting := [one for one in asked if not one.done][: options.max_parallel]:
            answers = client.ask_all([_conversation(one, source, cameras, grammar) for one in waiting])
            for one, answer in zip(waiting, answers, strict=True):
                _take(one, answer, grammar)
            bar.update(sum(len(one.texts) for one in asked) - bar.n)
    return {one.episode.episode: one.texts for one in asked}


def _take(one: _Asked, answer: str, grammar: Grammar) -> None:
    problem = _problem(one, answer, grammar)
    if problem and len(one.refused) + 1 < _ATTEMPTS:
        one.refused.append((answer, problem))
        return
    one.texts.append("" if problem else answer if grammar.is_free else grammar.canonical(answer))
    one.refused.clear()


def _problem(one: _Asked, answer: str, grammar: Grammar) -> str:
    """What is wrong with an answer, as the model is told; empty where nothing is."""
    if not grammar.is_parsable(answer):
        forms = nearest_forms(answer[:200], 3, grammar)
        return f"This is not one of the forms; the nearest are: {'; '.join(forms)}. Answer in one of the forms."
    implied, opened = grammar.gripper_implied(answer), _opened(one.episode, len(one.texts))
    if implied is not None and opened is not None and implied != opened[1]:
        state = "open" if opened[1] else "closed"
        return f"The gripper is {state} at the end, so this is not it. Answer with an action that leaves it {state}."
    return ""


def _opened(episode: FoundKeyframes, segment: int) -> tuple[bool, bool] | None:
    if schema.HAND_NAMES[7] not in episode.names:
        return None
    begin, end = (0, *episode.keyframes)[segment : segment + 2]
    return bool(episode.opened[begin]), bool(episode.opened[end])


def _words(episode: FoundKeyframes, segment: int) -> str:
    begin, end = (0, *episode.keyframes)[segment : segment + 2]
    poses = episode.states[:, list(hand_columns(episode.names)[:7])]
    return motion_words(poses[begin], poses[end], _opened(episode, segment))


def _conversation(one: _Asked, source: LeRobotDataset, cameras: Sequence[str], grammar: Grammar) -> list[Message]:
    segment, count = len(one.texts), len(one.episode.keyframes)
    steps = []
    for number in range(count):
        known = f": {one.texts[number] or 'unknown'}" if number < segment else ""
        steps.append(f"{number + 1}. {_words(one.episode, number)}{known}")
    content: list[dict[str, Any]] = [
        _text(f"The skill: {one.episode.task}. What the hand did in each of its actions, and those named so far:"),
        _text("\n".join(steps)),
    ]
    for when, frame in zip(("before", "after"), one.frames[segment : segment + 2], strict=True):
        item: Mapping[str, Any] = source[frame]
        for camera in cameras:
            content.append(_text(f"{when} action {segment + 1}, camera {camera}:"))
            url = data_url(item[schema.image_key(camera)], "jpeg")
            content.append({"type": "image_url", "image_url": {"url": url}})
    content.append(_text(f"Which basic action is action {segment + 1} ({_words(one.episode, segment)})?"))
    messages: list[Message] = [
        {"role": "system", "content": f"{_OPENING}\n{answer_forms(grammar)}"},
        {"role": "user", "content": content},
    ]
    for answer, problem in one.refused:
        messages.append({"role": "assistant", "content": answer or "(no answer)"})
        messages.append({"role": "user", "content": problem})
    return messages


def _text(text: str) -> dict[str, Any]:
    return {"type": "text", "text": text}
