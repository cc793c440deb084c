"""The tasks of ``llakey_sim``: every module of this folder that holds a :class:`Task` is found by itself."""

from __future__ import annotations

import functools
import importlib
import pkgutil

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.tasks.base import Task


@functools.cache
def task_classes() -> dict[str, type[Task]]:
    """The known tasks by name, sorted."""
    found: dict[str, type[Task]] = {}
    for module in pkgutil.iter_modules(__path__):
        for value in vars(importlib.import_module(f"{__name__}.{module.name}")).values():
            if isinstance(value, type) and issubclass(value, Task) and value is not Task:
                found[value.name] = value
    return dict(sorted(found.items()))


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
