"""Joining what several machines collected: the dataset that one run would have made."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lerobot_llakey.datasets.collect_record import RECORD, read_record
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.datasets.opening import open_metadata
from lerobot_llakey.datasets.places import PARTS_SUFFIX
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.shards import Shard

_SHARD = "shard"


def merge_shards(sources: Sequence[Path], target: Path, repo_id: str) -> None:
    """As :func:`merge`, but shards of a collection are put in their order, whatever the order they are named in.

    They become what one run would have made: the same episodes in the same order, and a record with which ``llakey
    collect`` can extend it.

    Args:
        sources: folders of datasets: all shards of one collection, each once, or any datasets that are no shards.
        target: folder of the new dataset, which must not exist yet.
        repo_id: its name.

    Raises:
        LlakeyError: if a shard is missing, comes twice, is not whole or is of another collection, or as in ``merge``.
        FileInTheWayError: if the folder exists.
    """
    records = {root: read_record(root) for root in sources if (root / RECORD).exists()}
    shards = {root: record for root, record in records.items() if _SHARD in record["settings"]}
    if not shards:
        merge(sources, target, repo_id)
        return
    if others := [root for root in sources if root not in shards]:
        if others[0].name.endswith(PARTS_SUFFIX):
            raise LlakeyError(f"Expected finished shards, got {others[0]}; first repeat the command that was stopped.")
        raise LlakeyError(
            f"Expected shards alone, got {others[0]}, which is none; merge the shards first, then both datasets."
        )
    settings = _common_settings(shards)
    ordered = _in_order(sources, shards)
    for root in ordered:
        _check_whole(root, shards[root])
    total: Counter[str] = Counter()
    for root in ordered:
        total += Counter(shards[root]["discarded"])
    episodes = sum(int(shards[root]["episodes"]) for root in ordered)
    record = {"settings": settings, "episodes": episodes, "discarded": dict(total)}
    merge(ordered, target, repo_id, {RECORD: json.dumps(record, indent=2)})


def _common_settings(shards: dict[Path, dict[str, Any]]) -> dict[str, Any]:
    """What all shards were collected with."""
    (first, one), *others = [(root, _plan(record)) for root, record in shards.items()]
    for root, plan in others:
        if changed := [key for key in sorted({*one, *plan}) if one.get(key) != plan.get(key)]:
            raise LlakeyError(
                f"Expected shards of one collection, got another {', '.join(changed)} in {root} than in {first}; "
                "collect one of them anew."
            )
    return {key: value for key, value in next(iter(shards.values()))["settings"].items() if key != _SHARD}


def _plan(record: dict[str, Any]) -> dict[str, Any]:
    """The settings, with the number of shards and of episodes in all of them."""
    settings = dict(record["settings"])
    shard = settings.pop(_SHARD)
    return settings | {"number of shards": shard["count"], "number of episodes": shard["episodes"]}


def _in_order(sources: Sequence[Path], shards: dict[Path, dict[str, Any]]) -> list[Path]:
    found: dict[int, Path] = {}
    for root in sources:
        number = int(shards[root]["settings"][_SHARD]["number"])
        if number in found:
            raise LlakeyError(
                f"Expected each shard once, got shard {number} in {found[number]} and again in {root}; leave one out."
            )
        found[number] = root
    count = int(next(iter(shards.values()))["settings"][_SHARD]["count"])
    if missing := [f"{number}/{count}" for number in range(1, count + 1) if number not in found]:
        raise LlakeyError(
            f"Expected all {count} shards, got {len(found)} without {', '.join(missing)}; collect these with --shard, "
            "or name their folders."
        )
    return [found[number] for number in sorted(found)]


def _check_whole(root: Path, record: dict[str, Any]) -> None:
    shard = record["settings"][_SHARD]
    expected = len(Shard(int(shard["number"]), int(shard["count"])).of(int(shard["episodes"])))
    held = open_metadata(root).total_episodes
    if not expected == record["episodes"] == held:
        raise LlakeyError(
            f"Expected {expected} episodes in the shard {root}, got {held} and a record of {record['episodes']}; "
            "collect it anew."
        )
