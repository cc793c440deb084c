"""``llakey check``: what is wrong with a dataset, before anything is trained on it.

llakey check --repo_id=me/llakey_keysteps --root=outputs/keysteps --report=outputs/check
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from lerobot_llakey import schema
from lerobot_llakey.bounds import require_box, require_count
from lerobot_llakey.checks.dataset import find, needs_all
from lerobot_llakey.checks.finding import Finding
from lerobot_llakey.checks.pictures import FRAMES, check_pictures, draw, pictured
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.collect import quieten
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.files import check_writable, reading, write_whole
from lerobot_llakey.inspection.check_report import HEADER, check_report, finding_cells
from lerobot_llakey.reporting.tables import markdown_table


@dataclass
class CheckConfig:
    """Options of ``llakey check``.

    Attributes:
        repo_id: a dataset on the Hub or in the folder ``root``.
        root: its folder; by default LeRobot's home folder or the Hub.
        frames: pictures are decoded of so many frames; 0 looks at the columns alone.
        workspace: bounds in metres of x, y and z that keyframes must keep, as the policy's setting of that name;
            by default any place will do.
        report: a folder that index.html is written into, with counts, findings and pictures of the first bad frames.
    """

    repo_id: str
    root: Path | None = None
    frames: int = FRAMES
    workspace: list[list[float]] | None = None
    report: Path | None = None

    def __post_init__(self) -> None:
        require_count("--frames", self.frames)
        if self.workspace is not None:
            require_box("--workspace", self.workspace, schema.FARTHEST)
        if self.report is not None:
            check_writable(self.report)


@with_options
def run(config: CheckConfig) -> None:
    """List what was found.

    Raises:
        SystemExit: with status 1 where training would be refused.
    """
    quieten()
    dataset = open_dataset(config.repo_id, config.root)
    bounds = config.workspace and tuple((float(low), float(high)) for low, high in config.workspace)
    workspace = cast(schema.Workspace | None, bounds)
    found = find(dataset.meta, needs_all(dataset.features, workspace))
    looked = _look(dataset, config.frames, workspace, found)
    refused = [finding for finding in found if finding.certain]
    if found:
        print(markdown_table(HEADER, [finding_cells(one) for one in found]))
    print(
        f"{config.repo_id}: {dataset.meta.total_episodes} episodes, {dataset.meta.total_frames} frames, pictures of "
        f"{looked}; {len(refused)} refused, {len(found) - len(refused)} warnings"
    )
    if config.report is not None:
        page = config.report / "index.html"
        write_whole(page, check_report(dataset, found, config.repo_id))
        print(f"report: {page}")
    if refused:
        raise SystemExit(1)


def _look(dataset: Any, count: int, workspace: schema.Workspace | None, found: list[Finding]) -> int:
    """Add what pictures tell, where the columns that they are held against are sound; number of frames looked at."""
    cameras = schema.cameras_of(dataset.features, depth=True)
    needed = pictured(cameras)
    broken = {finding.column for finding in found if finding.certain} & needed
    if not count or not cameras or not needed <= set(dataset.features) or broken:
        return 0
    with reading(dataset.root, "dataset"):
        sample = draw(dataset, cameras, count)
    found.extend(check_pictures(sample, workspace))
    found.sort(key=lambda finding: not finding.certain)
    return len(sample.hands)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
