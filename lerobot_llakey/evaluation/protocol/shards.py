"""A table whose episodes are run in shards, by machines that do not know of one another, and then put together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lerobot_llakey.evaluation.protocol.plan import Plan, Trial
from lerobot_llakey.evaluation.protocol.records import EPISODES, Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.evaluation.protocol.settings import require_settings
from lerobot_llakey.files import alone_in
from lerobot_llakey.shards import Shard

_SHARDS = "shards"


def shard_folder(folder: Path, shard: Shard) -> Path:
    """Where a shard of a table keeps its settings and records, within the table's folder."""
    return folder / _SHARDS / shard.name


def trials_of(plan: Plan, rows: Sequence[Row], shard: Shard) -> list[Trial]:
    """The shard's episodes, in the order of the whole table, so that most shards load few policies.

    Raises:
        LlakeyError: if there are more shards than episodes.
    """
    trials = plan.trials(rows)
    ours = shard.of(len(trials))
    return trials[ours.start : ours.stop]


def gather(folder: Path, settings: dict[str, Any], records: Records) -> int:
    """Take over what the shards in a table's folder have done.

    Nothing is lost or doubled: an episode that has a record already, here or in another shard, is left out, and one
    without any is run by the table itself.

    Args:
        folder: of the table.
        settings: of the table.
        records: of the table; grows.

    Returns:
        Number of records taken over.

    Raises:
        LlakeyError: if a shard is still running, was begun with other settings, or its records cannot be read.
    """
    before = len(records)
    for shard in sorted((folder / _SHARDS).glob("*/")):
        with alone_in(shard):
            require_settings(shard, settings)
            for record in Records(shard / EPISODES):
                if record.trial not in records:
                    records.add(record)
    return len(records) - before
