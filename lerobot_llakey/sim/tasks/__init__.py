"""The tasks of ``llakey_sim``: every :class:`Task` in a module of this folder, and those registered elsewhere."""

from __future__ import annotations

import functools
import importlib
import pkgutil

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.tasks.base import Task

_REGISTERED: dict[str, type[Task]] = {}


def register_task[Kind: type[Task]](kind: Kind) -> Kind:
    """Make a task of one's own known under its name; a decorator for its class.

    Raises:
        LlakeyError: if another class has the name.
    """
    known = task_classes().get(kind.name, kind)
    if known is not kind:
        raise LlakeyError(
            f"Expected a name of its own for the task {kind.__qualname__}, got {kind.name!r}, which is "
            f"{known.__module__}.{known.__qualname__}; name it otherwise."
        )
    _REGISTERED[kind.name] = kind
    return kind


def task_classes() -> dict[str, type[Task]]:
    """The known tasks by name, sorted."""
    return dict(sorted((_built_in() | _REGISTERED).items()))


@functools.cache
def _built_in() -> dict[str, type[Task]]:
    found: dict[str, type[Task]] = {}
    for module in pkgutil.iter_modules(__path__):
        for value in vars(importlib.import_module(f"{__name__}.{module.name}")).values():
            if isinstance(value, type) and issubclass(value, Task) and value is not Task:
                found[value.name] = value
    return found


def make_task(name: str) -> Task:
    """A fresh task by name.

    Raises:
        LlakeyError: if there is no such task.
    """
    return task_classes()[parse_tasks(name)[0]]()


def parse_tasks(names: str) -> list[str]:
    """Task names of a comma list, or of ``all``.

    Raises:
        LlakeyError: if a name is unknown or comes twice, or none is given.
    """
    known = list(task_classes())
    asked = known if names.strip() == "all" else [name.strip() for name in names.split(",") if name.strip()]
    unknown = [name for name in asked if name not in known]
    if unknown or not asked:
        raise LlakeyError(f"Expected tasks out of {', '.join(known)} or all, got {names!r}; correct --task.")
    if twice := [name for name in known if asked.count(name) > 1]:
        raise LlakeyError(f"Expected each task once, got {twice[0]!r} twice in {names!r}; name it once.")
    return asked
