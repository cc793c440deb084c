"""Tables for the terminal and for Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.rollout.actors import Episode


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table whose columns line up when read as plain text."""
    lines = [header, *rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    written = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |" for line in lines
    ]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    return "\n".join([written[0], rule, *written[1:]])


def success_table(episodes: Sequence[Episode]) -> str:
    """Episodes, successes and mean number of actions of each task, and their average over tasks.

    Raises:
        LlakeyError: if there are no episodes.
    """
    if not episodes:
        raise LlakeyError("Expected at least one episode, got none; raise --num_episodes.")
    rows, rates = [], []
    for task in dict.fromkeys(episode.task for episode in episodes):
        of_task = [episode for episode in episodes if episode.task == task]
        solved = [episode for episode in of_task if episode.success]
        rates.append(len(solved) / len(of_task))
        actions = sum(len(episode.instructions) for episode in of_task) / len(of_task)
        rows.append([task, str(len(of_task)), str(len(solved)), f"{100 * rates[-1]:.0f} %", f"{actions:.1f}"])
    rows.append(["average", str(len(episodes)), "", f"{100 * sum(rates) / len(rates):.0f} %", ""])
    return markdown_table(["task", "episodes", "solved", "success", "actions"], rows)
