"""What goes to the Hub beside the weights: processors, and LeRobot's card with what the policy is and its results."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from huggingface_hub import ModelCard
from lerobot.policies.pretrained import PreTrainedPolicy

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.processor_llakey import make_llakey_pre_post_processors

RESULTS_FILE = "results.json"
"""Name of an evaluation's figures, in the folder of the evaluation or of a checkpoint."""

ABOUT = """This is a LLaKey policy (*Follow My Basic Action Instructions to Your Next Key State*): a command policy, a
vision-language model, looks at the scene and says the next basic action in words; an action policy, a multi-view
transformer on the point cloud, turns them into the next keyframe pose. It needs the `lerobot_policy_llakey` package,
which LeRobot finds by its name."""

_PLACEHOLDER = "_No evaluation results have been provided for this policy yet._"


def results_table(results: Any) -> str:
    """The Markdown table of an evaluation's figures.

    Args:
        results: content of a ``results.json``, in one of three forms: a finished table under ``markdown``; under
            ``rows``, for each row of a table, ``tasks`` and ``average`` with ``success`` and ``spread`` in 0..1, as
            ``llakey table`` writes them; under ``episodes`` a list with ``task`` and ``success``, as ``llakey demo``.

    Raises:
        LlakeyError: if it holds none of them.
    """
    try:
        if "markdown" in results:
            return str(results["markdown"]).strip()
        return _table_of_rows(results["rows"]) if "rows" in results else _table_of_episodes(results["episodes"])
    except (KeyError, TypeError, AttributeError, ZeroDivisionError) as error:
        raise LlakeyError(
            "Expected results with a table under 'markdown', rows with 'tasks' and 'average' under 'rows', or episodes "
            "with 'task' and 'success' under 'episodes', got none of them; give the results.json of an evaluation."
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


def read_results(path: str | Path) -> str:
    """The Markdown table in a ``results.json``, or in the one in a folder.

    Raises:
        MissingFileError: if there is none.
        LlakeyError: if it is no evaluation's.
    """
    file = Path(path) / RESULTS_FILE if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise MissingFileError(f"Expected the results of an evaluation at {file}, got nothing; correct results_path.")
    try:
        return results_table(json.loads(file.read_text(encoding="utf-8")))
    except ValueError as error:
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


def fill_card(card: ModelCard, table: str | None) -> ModelCard:
    """Say in LeRobot's card what the policy is, and put the table where its results belong.

    Args:
        card: as LeRobot makes it.
        table: in Markdown; None leaves the results as LeRobot has them.
    """
    heading = card.text.find("\n---\n")
    text = f"{card.text[:heading]}\n{ABOUT}\n{card.text[heading:]}" if heading >= 0 else f"{card.text}\n\n{ABOUT}\n"
    if table is not None:
        known = _PLACEHOLDER in text
        text = text.replace(_PLACEHOLDER, table) if known else f"{text}\n\n## Evaluation\n\n{table}\n"
    card.text = text
    return card


class PublishedPolicy(PreTrainedPolicy):
    """A policy that is pushed with its processors and a card with its results.

    Attributes:
        evaluated_in: folder in which a ``results.json`` of just these weights may lie: where they were loaded from.
    """

    config_class = LlakeyConfig
    name = "llakey"
    config: LlakeyConfig
    evaluated_in: Path | None = None

    def generate_model_card(self, *args: Any, **kwargs: Any) -> ModelCard:
        """LeRobot's card, with what the policy is and, where an evaluation is known, its table of results.

        Args:
            *args: as LeRobot's.
            **kwargs: likewise.

        Raises:
            MissingFileError: if ``results_path`` leads nowhere.
            LlakeyError: if what is there is no evaluation.
        """
        return fill_card(
            super().generate_model_card(*args, **kwargs), known_results(self.config.results_path, self.evaluated_in)
        )

    def push_to_hub(self, repo_id: str, **kwargs: Any) -> str:
        """Upload the checkpoint with its processors and its model card; see LeRobot's ``push_to_hub``."""
        kwargs["card_kwargs"] = kwargs.get("card_kwargs") or {}
        return str(super().push_to_hub(repo_id, **kwargs))

    def save_pretrained(
        self, save_directory: str | Path, *, card_kwargs: dict[str, Any] | None = None, **kwargs: Any
    ) -> str | None:
        """Write the checkpoint; with ``card_kwargs``, which pushing gives, its card and processors as well."""
        if card_kwargs is not None:
            config = self.config
            card = self.generate_model_card(None, config.type, config.license, config.tags)
            Path(save_directory).mkdir(parents=True, exist_ok=True)
            card.save(Path(save_directory) / "README.md")
            for pipeline in make_llakey_pre_post_processors(config):
                pipeline.save_pretrained(save_directory)
        pushed: str | None = super().save_pretrained(save_directory, card_kwargs=card_kwargs, **kwargs)
        return pushed
