"""``llakey check``: what is wrong with a dataset, before anything is trained on it.

llakey check --repo_id=me/llakey_keysteps --root=outputs/keysteps
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_count
from lerobot_llakey.checks.dataset import find, needs_all
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.checks.metadata import cameras_of
from lerobot_llakey.checks.pictures import FRAMES, check_pictures, draw
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.collect import quieten
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.reporting.tables import markdown_table


@dataclass
class CheckConfig:
    """Options of ``llakey check``.

    Attributes:
        repo_id: a dataset on the Hub or in the folder ``root``.
        root: its folder; by default LeRobot's home folder or the Hub.
        frames: pictures are decoded of so many frames; 0 looks at the columns alone.
        workspace: bounds in metres of x, y and z that keyframes must keep, as the policy's setting of that name.
    """

    repo_id: str
    root: Path | None = None
    frames: int = FRAMES
    workspace: list[list[float]] = field(default_factory=lambda: [list(bounds) for bounds in schema.WORKSPACE])

    def __post_init__(self) -> None:
        require_count("--frames", self.frames)
        if len(self.workspace) != 3 or any(len(bounds) != 2 or not bounds[0] < bounds[1] for bounds in self.workspace):
            raise LlakeyError(f"Expected --workspace as three (low, high) pairs, got {self.workspace}; correct it.")


@with_options
def run(config: CheckConfig) -> None:
    """List what was found.

    Raises:
        SystemExit: with status 1 where training would be refused.
    """
    quieten()
    dataset = open_dataset(config.repo_id, config.root)
    workspace = cast(schema.Workspace, tuple((float(low), float(high)) for low, high in config.workspace))
    found = find(dataset.meta, needs_all(dataset.features, workspace))
    looked = _look(dataset, config.frames, workspace, found)
    refused = [finding for finding in found if finding.certain]
    if found:
        print(_table(found))
    print(
        f"{config.repo_id}: {dataset.meta.total_episodes} episodes, {dataset.meta.total_frames} frames, pictures of "
        f"{looked}; {len(refused)} refused, {len(found) - len(refused)} warnings"
    )
    if refused:
        raise SystemExit(1)


def _look(dataset: Any, count: int, workspace: schema.Workspace, found: list[Finding]) -> int:
    """Add what pictures tell, where the columns that they are held against are sound; number of frames looked at."""
    cameras = cameras_of(dataset.features)
    needed = {schema.STATE, schema.ACTION, schema.INTRINSICS, schema.EXTRINSICS}
    needed |= {key for camera in cameras for key in (schema.image_key(camera), schema.depth_key(camera))}
    broken = {finding.column for finding in found if finding.certain} & needed
    if not count or not needed <= set(dataset.features) or broken:
        return 0
    with reading(dataset.root, "dataset"):
        sample = draw(dataset, cameras, count)
    found.extend(check_pictures(sample, workspace))
    found.sort(key=lambda finding: not finding.certain)
    return len(sample.states)


def _table(found: list[Finding]) -> str:
    rows = [
        ["refused" if one.certain else "warning", one.column, one.expected, one.got, one.place or "-", one.advice]
        for one in found
    ]
    return markdown_table(["", "column", "expected", "got", "at", "what to do"], rows)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
