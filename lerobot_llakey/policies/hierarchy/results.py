"""The figures of an evaluation, as a table for a model card."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading

RESULTS_FILE = "results.json"
"""Name of an evaluation's figures, in the folder of the evaluation or of a checkpoint."""


def results_table(results: Any) -> str:
    """The Markdown table of an evaluation's figures.

    Args:
        results: content of a ``results.json``, in one of four forms: a finished table under ``markdown``; under
            ``rows``, for each row of a table, ``tasks`` and ``average`` with ``success`` and ``spread`` in 0..1, as
            ``llakey table`` writes them; under ``episodes`` a list with ``task`` and ``success``, as ``llakey demo``;
            under ``per_group`` and ``overall`` the percentage ``pc_success`` of ``n_episodes``, as ``lerobot-eval``.

    Raises:
        LlakeyError: if it holds none of them.
    """
    try:
        if "markdown" in results:
            return str(results["markdown"]).strip()
        if "per_group" in results:
            return _table_of_groups(results["per_group"], results["overall"])
        return _table_of_rows(results["rows"]) if "rows" in results else _table_of_episodes(results["episodes"])
    except (KeyError, TypeError, ValueError, AttributeError, ZeroDivisionError) as error:
        raise LlakeyError(
            "Expected results with a table under 'markdown', rows with 'tasks' and 'average' under 'rows', episodes "
            "with 'task' and 'success' under 'episodes', or groups under 'per_group', got none of them; give the "
            "results.json of an evaluation, or lerobot-eval's eval_info.json."
        ) from error


def _table_of_rows(rows: Mapping[str, Any]) -> str:
    tasks = list(dict.fromkeys(task for row in rows.values() for task in row["tasks"]))
    lines = [f"| success | {' | '.join(f'`{task}`' for task in tasks)} | average |", "|---" * (len(tasks) + 2) + "|"]
    for name, row in rows.items():
        cells = [*(row["tasks"].get(task) for task in tasks), row["average"]]
        lines.append(f"| {' | '.join([name, *map(_cell, cells)])} |")
    return "\n".join(lines)


def _cell(figures: Mapping[str, float] | None) -> str:
    """Percent, and the spread over repeats."""
    return "" if figures is None else f"{100 * figures['success']:.1f} ± {100 * figures['spread']:.1f}"


def _table_of_episodes(episodes: Sequence[Mapping[str, Any]]) -> str:
    lines, shares = ["| task | episodes | success |", "|---|---|---|"], []
    for task in dict.fromkeys(one["task"] for one in episodes):
        outcomes = [bool(one["success"]) for one in episodes if one["task"] == task]
        shares.append(sum(outcomes) / len(outcomes))
        lines.append(f"| `{task}` | {len(outcomes)} | {sum(outcomes)} ({100 * shares[-1]:.0f} %) |")
    lines.append(f"| average | {len(episodes)} | {100 * sum(shares) / len(shares):.0f} % |")
    return "\n".join(lines)


def _table_of_groups(groups: Mapping[str, Any], overall: Mapping[str, Any]) -> str:
    rows = [*((f"`{task}`", figures) for task, figures in groups.items()), ("overall", overall)]
    cells = [(name, int(row["n_episodes"]), float(row["pc_success"])) for name, row in rows]
    lines = [f"| {name} | {episodes} | {success:.0f} % |" for name, episodes, success in cells]
    return "\n".join(["| task | episodes | success |", "|---|---|---|", *lines])


def read_results(path: str | Path) -> str:
    """The Markdown table in a ``results.json``, or in the one in a folder.

    Raises:
        MissingFileError: if there is none.
        LlakeyError: if it is no evaluation's.
    """
    file = Path(path) / RESULTS_FILE if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise MissingFileError(f"Expected the results of an evaluation at {file}, got nothing; correct the path.")
    with reading(file, "JSON file"):
        results = json.loads(file.read_text(encoding="utf-8"))
    try:
        return results_table(results)
    except LlakeyError as error:
        raise LlakeyError(f"{file}: {error}") from error


def known_results(path: str | None, folder: Path | None) -> str | None:
    """The table that a setting names, else that of the ``results.json`` in a folder, else None.

    Raises:
        MissingFileError: if the setting leads nowhere.
        LlakeyError: if there is something else.
    """
    if path is not None:
        return read_results(path)
    return read_results(folder) if folder is not None and (folder / RESULTS_FILE).is_file() else None
