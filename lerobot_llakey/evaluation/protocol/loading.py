"""Which rows can be run, and loading the policies that one names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import draccus

from lerobot_llakey.errors import MissingFileError
from lerobot_llakey.evaluation.protocol.rows import EXPERT, Row
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.policies.hierarchy.processor_llakey import make_llakey_pre_post_processors
from lerobot_llakey.rollout.actors import Actor, Agent, Expert, command_line
from lerobot_llakey.saved.folder import find_checkpoint, inspect_checkpoint


@dataclass(frozen=True)
class Runnable:
    """The rows of a table.

    Attributes:
        rows: those that can be run.
        missing: names of the others, with the reason.
    """

    rows: list[Row]
    missing: dict[str, str] = field(default_factory=dict)


def runnable(rows: Sequence[Row]) -> Runnable:
    """Tell the rows apart whose checkpoints are there.

    Raises:
        MissingFileError: if no row can be run.
    """
    missing = {row.name: reason for row in rows if (reason := why_missing(row))}
    found = [row for row in rows if row.name not in missing]
    if not found:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in missing.items())
        raise MissingFileError(f"Expected at least one row with a checkpoint, got none ({reasons}); correct --rows.")
    return Runnable(found, missing)


def why_missing(row: Row) -> str:
    """Why a row cannot be run, in a few words; empty where it can.

    Raises:
        LlakeyError: if a checkpoint is there but broken, or the Hub does not give it.
    """
    unfilled = [name for name, value in row.overrides.items() if value in (None, "")]
    if unfilled:
        return f"{', '.join(unfilled)} is not filled in"
    return next((f"no checkpoint at {path}" for path in row.paths if not _is_there(path)), "")


def load_row(row: Row, oracle: bool = False) -> Actor:
    """The policy of a row, ready to act.

    Args:
        row: what to load; :func:`why_missing` has found nothing.
        oracle: let the expert's instructions, which the environment must give, take the command policy's place.

    Raises:
        MissingFileError: if a checkpoint is missing.
        LlakeyError: if one is of another kind, or a setting is unknown.
    """
    if row.policy_path == EXPERT:
        return Expert()
    paths = {"command_path": row.command_path, "action_path": row.action_path}
    overrides = {**row.overrides, **{name: path for name, path in paths.items() if path}}
    if row.policy_path:
        agent = Agent.load(row.policy_path, oracle, overrides)
    else:
        agent = _joined(overrides | {"commander": "oracle"} if oracle else overrides)
    command = getattr(agent.policy, "command", None)
    if row.views and command is not None:
        command.config.cameras = list(row.views)
    return agent


def _joined(overrides: Mapping[str, Any]) -> Agent:
    """A hierarchy out of a command and an action policy."""
    policy = LlakeyPolicy(draccus.parse(LlakeyConfig, args=command_line(overrides))).eval()
    preprocessor, postprocessor = make_llakey_pre_post_processors(policy.config)
    return Agent(policy, preprocessor, postprocessor)


def _is_there(path: str) -> bool:
    """Whether there is a checkpoint; one that was not trained yet is none, a broken one is an error."""
    try:
        folder = find_checkpoint(path)
    except MissingFileError:
        return False
    if not any(folder.iterdir()):
        return False
    inspect_checkpoint(folder)
    return True
