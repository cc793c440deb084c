"""What the page is told, and what it may ask for, in plain data for JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.labelling.curves import opening, speed
from lerobot_llakey.labelling.session import LabelSession
from lerobot_llakey.labelling.suggestions import suggest


def overview(session: LabelSession, cameras: tuple[str, ...], repo_id: str) -> dict[str, Any]:
    """The dataset, and how far each episode is."""
    return {
        "repo_id": repo_id,
        "file": str(session.path),
        "cameras": list(cameras),
        "free": session.grammar.is_free,
        "episodes": [progress(session, episode) for episode in session.found],
    }


def progress(session: LabelSession, episode: int) -> dict[str, Any]:
    """How far an episode is."""
    return {"episode": episode, "task": session.found[episode].task, "complete": session.complete(episode)}


def keyframes(session: LabelSession, episode: int) -> dict[str, Any]:
    """What a correction may change about an episode."""
    stand = session.keyframes(episode)
    opened, read = session.found[episode].opened, session.grammar.is_parsable
    listed = [
        {"frame": one.frame, "text": one.instruction, "open": bool(opened[one.frame]), "valid": read(one.instruction)}
        for one in stand
    ]
    return progress(session, episode) | {"keyframes": listed, "alike": session.alike(episode)}


def episode(session: LabelSession, number: int) -> dict[str, Any]:
    """All about an episode but its pictures."""
    told = keyframes(session, number)
    found = session.found[number]
    return told | {
        "frames": len(found.states),
        "fps": found.fps,
        "opening": opening(found).round(3).tolist(),
        "speed": speed(found).round(4).tolist(),
    }


def correct(session: LabelSession, number: int, wanted: Mapping[str, Any]) -> dict[str, Any]:
    """Make a correction, and tell the keyframes after it.

    Args:
        session: that is corrected.
        number: of the episode.
        wanted: ``{"do": "move", "frame": 12, "to": 15}``, or with another of the session's methods and its arguments.

    Raises:
        LlakeyError: if it is no correction or the session refuses it.
    """
    methods: dict[str, tuple[Callable[..., None], tuple[tuple[str, type], ...]]] = {
        "move": (session.move, (("frame", int), ("to", int))),
        "add": (session.add, (("frame", int),)),
        "remove": (session.remove, (("frame", int),)),
        "say": (session.say, (("frame", int), ("text", str))),
        "fill": (session.fill, (("source", int),)),
    }
    name = wanted.get("do")
    if not isinstance(name, str) or name not in methods:
        raise LlakeyError(f"Expected a correction out of {', '.join(methods)}, got {name!r}; load the page anew.")
    method, arguments = methods[name]
    for argument, kind in arguments:
        if type(wanted.get(argument)) is not kind:
            raise LlakeyError(
                f"Expected {argument} of {name} as {kind.__name__}, got {wanted.get(argument)!r}; load the page anew."
            )
    method(number, *(wanted[argument] for argument, _ in arguments))
    return keyframes(session, number)


def suggestions(session: LabelSession, number: int, segment: int, text: str) -> dict[str, Any]:
    """What to offer while an instruction is typed."""
    return asdict(suggest(session, number, segment, text))
