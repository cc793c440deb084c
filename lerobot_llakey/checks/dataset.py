"""One check of a dataset's columns, before the first training step and for ``llakey check``."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Iterator
from dataclasses import asdict, dataclass, is_dataclass, replace
from pathlib import Path
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.checks.calibration import check_extrinsics, check_intrinsics, check_views
from lerobot_llakey.checks.checksums import check_checksums
from lerobot_llakey.checks.columns import MOST_ROWS, Columns, read_columns
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.checks.foreign_files import refuse_paths_outside
from lerobot_llakey.checks.keyframes import check_gripper, check_segments_actions, check_spacing
from lerobot_llakey.checks.labels import check_labels
from lerobot_llakey.checks.loader import refuse_moved_colours
from lerobot_llakey.checks.look import warn_of_pictures
from lerobot_llakey.checks.metadata import (
    check_cameras,
    check_pictures_notes,
    check_shapes,
    check_uncalibrated,
    sizes_of,
)
from lerobot_llakey.checks.motion import check_motion
from lerobot_llakey.checks.numbers import check_action, check_finite, check_state, check_weights
from lerobot_llakey.checks.order import check_keyframes, check_order, is_dense
from lerobot_llakey.checks.texts import check_instructions, check_segments, check_tasks
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import of_features

_CHECKED = "_llakey_checked"


@dataclass(frozen=True)
class Needs:
    """What of a dataset is read.

    Attributes:
        columns: names of features; what is wrong with others does not matter.
        cameras: whose depth is read, and with it their calibration; None for all that have both.
        views: whose colours alone are read.
        depth: whether depth is read.
        workspace: bounds in metres that keyframes must keep; None where any place will do.
        weight_key: of the samples' weights.
    """

    columns: frozenset[str]
    cameras: tuple[str, ...] | None = None
    views: tuple[str, ...] = ()
    depth: bool = True
    workspace: schema.Workspace | None = None
    weight_key: str = schema.SAMPLE_WEIGHT

    def __or__(self, other: Needs) -> Needs:
        """What either needs."""
        ours = self if self.depth else other
        return replace(ours, columns=self.columns | other.columns, views=self.views + other.views)

    def covers(self, other: Needs) -> bool:
        """Whether a dataset that serves this serves the other too."""
        same = not other.depth or (self.cameras, self.workspace, self.depth) == (other.cameras, other.workspace, True)
        return same and self.weight_key == other.weight_key and self.columns >= other.columns

    def cameras_in(self, features: Collection[str]) -> tuple[str, ...]:
        """The cameras of a dataset whose depth is read."""
        if not self.depth:
            return ()
        return schema.cameras_of(features, depth=True) if self.cameras is None else self.cameras


def needs_all(features: Collection[str], workspace: schema.Workspace | None = None) -> Needs:
    """Everything that a dataset holds."""
    has_depth = bool(schema.cameras_of(features, depth=True))
    views = schema.cameras_of(features)
    return Needs(frozenset({*features, schema.TASK}), views=views, depth=has_depth, workspace=workspace)


def find(meta: Any, needs: Needs, most: int = MOST_ROWS) -> list[Finding]:
    """All that is wrong with the columns of a dataset, each fault once.

    Args:
        meta: a ``LeRobotDatasetMetadata`` whose files are on this disk.
        needs: what is read of it.
        most: rows to look at; of a larger dataset, files at equal distances.

    Raises:
        LlakeyError: if a file cannot be read, or names others.
    """
    root, features = Path(meta.root), meta.features
    refuse_paths_outside(root, _as_mapping(meta.info))
    found = [*check_checksums(root), *_of_metadata(meta, needs)]
    # What has not the contract's shape cannot be looked at further.
    broken = {finding.column for finding in found if finding.got.startswith("shape")}
    readable = {key: feature for key, feature in features.items() if key not in broken}
    for columns in read_columns(root, readable, most):
        found += _of_columns(columns, needs, features)
    once: dict[tuple[str, str], Finding] = {}
    for finding in found:
        once.setdefault(finding.kind, finding)
    return sorted(once.values(), key=lambda finding: not finding.certain)


def check_dataset(meta: Any, needs: Needs) -> None:
    """Refuse a dataset that cannot be trained on; log what is likely wrong.

    A dataset that is not on this disk (a streamed one) is left to the checks of batches.

    Args:
        meta: a ``LeRobotDatasetMetadata``; one that has passed with the same needs is not read again.
        needs: what the policy reads.

    Raises:
        LlakeyError: naming the dataset, the column, the row and what it holds.
    """
    root = getattr(meta, "root", None)
    if root is None or not (Path(root) / "data").is_dir():
        return
    passed = meta.__dict__.setdefault(_CHECKED, set())
    if any(earlier.covers(needs) for earlier in passed):
        return
    name = str(getattr(meta, "repo_id", root))
    if needs.depth:
        refuse_moved_colours(meta)
    say(find(meta, needs), name)
    if needs.depth:
        warn_of_pictures(meta, needs.cameras_in(meta.features), needs.workspace, name)
    passed.add(needs)


def say(findings: Iterable[Finding], name: str) -> None:
    """Log warnings and raise the first refusal.

    Raises:
        LlakeyError: if there is one.
    """
    refused = [finding for finding in findings if finding.certain]
    for finding in findings:
        if not finding.certain:
            logging.warning(finding.sentence(name))
    if refused:
        more = f" (and {len(refused) - 1} other faults; llakey check lists them)" if len(refused) > 1 else ""
        raise LlakeyError(refused[0].sentence(name) + more)


def _of_metadata(meta: Any, needs: Needs) -> Iterator[Finding]:
    features = meta.features
    yield from check_shapes(features, needs.columns)
    stats = getattr(meta, "stats", None)
    cameras = needs.cameras_in(features)
    yield from check_cameras(features, cameras)
    yield from check_pictures_notes(features, stats, cameras, depth=True)
    yield from check_pictures_notes(features, stats, {*cameras, *needs.views}, depth=False)
    if needs.cameras is None:
        yield from check_uncalibrated({key: features[key] for key in features if key in needs.columns})
    if schema.TASK in needs.columns and getattr(meta, "tasks", None) is not None:
        yield from check_tasks([str(task) for task in meta.tasks.index])


def _of_columns(columns: Columns, needs: Needs, features: Any) -> Iterator[Finding]:
    yield from check_order(columns)
    yield from check_finite(columns, needs.columns)
    reads_state, reads_action = schema.STATE in needs.columns, schema.ACTION in needs.columns
    if reads_state:
        yield from check_state(columns)
    if reads_action:
        yield from check_action(columns, needs.workspace)
    yield from check_weights(columns, needs.weight_key)
    yield from check_instructions(columns, needs.columns, of_features(features, schema.INSTRUCTION))
    yield from check_segments(columns, needs.columns)
    dense = is_dense(columns)
    yield from check_keyframes(columns, dense)
    if reads_state and reads_action:
        yield from check_labels(columns, dense)
    if columns.is_finite(schema.STATE, schema.ACTION):
        yield from _of_motion(columns, dense, reads_state, reads_action)
    sizes = sizes_of(features, needs.cameras_in(features))
    yield from check_intrinsics(columns, sizes)
    yield from check_extrinsics(columns, list(sizes))
    yield from check_views(columns, sizes)


def _of_motion(columns: Columns, dense: bool, reads_state: bool, reads_action: bool) -> Iterator[Finding]:
    if reads_state:
        yield from check_motion(columns, dense)
    if reads_action:
        yield from check_segments_actions(columns)
        yield from check_spacing(columns)
    if reads_state and reads_action:
        yield from check_gripper(columns, dense)


def _as_mapping(info: Any) -> Any:
    return asdict(info) if is_dataclass(info) and not isinstance(info, type) else info
