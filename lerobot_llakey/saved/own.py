"""Settings that the user alone gives: a server, a key's variable, a path that is read or written.

A checkpoint that named them could send a secret to its author, or read and write files of whoever loads it.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import logging
import re
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from lerobot_llakey.errors import LlakeyError

log = logging.getLogger(__name__)

LEROBOTS_OWN = {"pretrained_path": None, "pretrained_revision": None, "repo_id": None}
"""Those of every policy of LeRobot: where it reads weights from, and where it uploads them to."""

_OWN, _WEIGHTS = "users_own", "names_weights"
_HUB_NAME = re.compile(r"[\w][\w.-]*(/[\w][\w.-]*)?")


def users_own(default: Any, unset: Any = None) -> Any:
    """A field of settings whose saved value is shown and ignored.

    Args:
        default: where the user gives nothing.
        unset: what a loaded checkpoint has in place of what was saved; ``default`` where None.
    """
    return dataclasses.field(default=default, metadata={_OWN: default if unset is None else unset})


def names_weights(are_read: Callable[[Mapping[str, Any], Path], bool] = lambda *_: True) -> Any:
    """A field, None by default, that names a model by Hub name or folder: a saved folder is refused.

    Args:
        are_read: whether weights are read under that name, from the settings around the field and the checkpoint.
    """
    return dataclasses.field(default=None, metadata={_WEIGHTS: are_read})


def own_settings(settings: type) -> dict[str, Any]:
    """The user's own settings by dotted name, with what takes a saved value's place.

    Args:
        settings: a dataclass, with others in its fields.
    """
    own = {
        name: found.metadata[_OWN] if _OWN in found.metadata else LEROBOTS_OWN[name.rpartition(".")[2]]
        for name, found in _fields(settings)
        if _OWN in found.metadata or name.rpartition(".")[2] in LEROBOTS_OWN
    }
    return own


def without_own(settings: type, saved: dict[str, Any], folder: Path, given: Sequence[str] = ()) -> None:
    """Take the user's own settings out of saved ones, and log those that said something.

    Args:
        settings: the dataclass that they are of.
        saved: what the file holds; changed.
        folder: of the checkpoint.
        given: what the user gives, as on a command line: ``--command.base_url=http://127.0.0.1:8000/v1``.

    Raises:
        LlakeyError: if weights are named by a path, which the user has to give.
    """
    options = {argument.removeprefix("--").partition("=")[0] for argument in given}
    ignored = []
    for name, unset in own_settings(settings).items():
        place, last = _place(saved, name)
        if place is None:
            continue
        if place.get(last, unset) not in (unset, None, "", _default(settings, name)) and name not in options:
            ignored.append((name, place[last]))
        place[last] = unset
    for name, value in ignored:
        log.warning(
            "The checkpoint %s was saved with %s=%s; ignored: give --policy.%s=... to use it.",
            *(folder, name, repr(value)[:80], name),
        )
    for name, found in _fields(settings):
        place, last = _place(saved, name)
        are_read = found.metadata.get(_WEIGHTS)
        if are_read is not None and place is not None and name not in options and are_read(place, folder):
            _refuse_path(place.get(last), f"policy.{name}")


def given_options(settings: Any) -> list[str]:
    """What the user gave of his own settings and of weights' names, as on a command line.

    Args:
        settings: that the user made.
    """
    options = []
    for name, found in _fields(type(settings)):
        value = functools.reduce(getattr, name.split("."), settings)
        if (_OWN in found.metadata or _WEIGHTS in found.metadata) and value not in (None, "", found.default):
            options.append(f"--{name}={json.dumps(value)}")
    return options


def is_hub_name(name: str) -> bool:
    """Whether something names a repository of the Hub rather than a place on this disk."""
    return _HUB_NAME.fullmatch(name) is not None and ".." not in name and not Path(name).exists()


def _refuse_path(value: Any, option: str) -> None:
    if isinstance(value, str) and not is_hub_name(value):
        raise LlakeyError(
            f"Expected a checkpoint that names weights of the Hub alone, got one that names the place {value!r}; if it "
            f"is yours, give --{option}={value} yourself."
        )


def _fields(settings: type, prefix: str = "") -> Iterator[tuple[str, dataclasses.Field[Any]]]:
    """All fields by dotted name, those of the dataclasses within included."""
    kinds = typing.get_type_hints(settings)
    for found in dataclasses.fields(settings):
        yield f"{prefix}{found.name}", found
        if dataclasses.is_dataclass(kinds[found.name]):
            yield from _fields(typing.cast(type, kinds[found.name]), f"{prefix}{found.name}.")


def _default(settings: type, name: str) -> Any:
    return dict(_fields(settings))[name].default


def _place(saved: dict[str, Any], name: str) -> tuple[dict[str, Any] | None, str]:
    """The mapping that holds a dotted name, and its last part; None where the mapping is not there."""
    *way, last = name.split(".")
    place: Any = saved
    for step in way:
        place = place.get(step) if isinstance(place, dict) else None
    return (place if isinstance(place, dict) else None), last
