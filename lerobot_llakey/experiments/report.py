"""One page that shows all that a reproduction gave."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from lerobot_llakey.evaluation.experiment import TABLE
from lerobot_llakey.evaluation.protocol.runner import VIDEOS
from lerobot_llakey.experiments import ambiguity
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.files import write_whole

REPORT = "report.md"
_PARTS: tuple[tuple[str, str, str, tuple[str, ...]], ...] = (
    ("Table I: success", "table", TABLE, ("table.png", "attribution.png")),
    ("Table I: the command policy's abilities", "abilities/3_views", "abilities.md", ("abilities.png", "verbs.png")),
    ("Table I: with one view", "abilities/1_view", "abilities.md", ("abilities.png", "verbs.png")),
    ("Figure 6: unforeseen events", "rollback", TABLE, ("rollback.png",)),
    ("Figure 1: the verbs of the skill instruction", "ambiguity", ambiguity.PAGE, (ambiguity.PLOT,)),
)
"""Title, folder, page and plots of each part of the report."""


def write_report(folder: Path, scale: str, trainings: Iterable[Training], times: str) -> Path:
    """Write ``report.md``: every table, its plots, links to the videos, what was trained and how long it took.

    Args:
        folder: of the reproduction.
        scale: name of its scale.
        trainings: that were run.
        times: a table of the stages' times.

    Returns:
        The page's path.
    """
    parts = [f"# The paper's experiments at the scale `{scale}`"]
    for title, place, page, plots in _PARTS:
        part = folder / place
        if (part / page).is_file():
            parts += [f"## {title}", _demoted((part / page).read_text())]
            parts += [f"![{Path(plot).stem}]({place}/{plot})" for plot in plots if (part / plot).is_file()]
            parts += _videos(folder, part / VIDEOS)
    commands = "\n".join(training.command_line() for training in trainings)
    parts += ["## Training", f"```bash\n{commands}\n```", "## Time", times]
    path = folder / REPORT
    write_whole(path, "\n\n".join(parts) + "\n")
    return path


def _demoted(page: str) -> str:
    """A page of its own as a part of another: its headings two levels lower."""
    return re.sub(r"(?m)^#", "###", page).strip()


def _videos(folder: Path, videos: Path) -> list[str]:
    """A line of links for each row's folder of videos."""
    lines = []
    for row in sorted(path for path in videos.glob("*") if path.is_dir()):
        links = [f"[{video.stem}]({video.relative_to(folder)})" for video in sorted(row.glob("*.mp4"))]
        lines.append(f"- {row.name}: {', '.join(links)}")
    return ["Videos:\n\n" + "\n".join(lines)] if lines else []
