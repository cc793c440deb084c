"""The dataset card: what a dataset says about itself, in the form that the Hub reads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

from huggingface_hub import DatasetCard, DatasetCardData
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.card_facts import CardFacts, read_facts
from lerobot_llakey.datasets.collect_record import RECORD, read_record
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import packaged

TEMPLATE = "dataset_cards/llakey_dataset.md"
TAGS = ["LeRobot", "llakey", "robotics", "keyframes"]
_MOST, _FEWER = 40, 20
"""Entries of a list, and of the list of the longest entries."""


def require_instructions(dataset: LeRobotDataset) -> None:
    """Refuse a dataset that is no LLaKey dataset.

    Raises:
        LlakeyError: if the dataset has no instruction column.
    """
    if schema.INSTRUCTION not in dataset.features:
        raise LlakeyError(
            f"Expected demonstrations or keysteps with {schema.INSTRUCTION}, got {dataset.repo_id} without; annotate "
            "it first."
        )


def make_card(dataset: LeRobotDataset, facts: CardFacts | None = None, license: str | None = None) -> DatasetCard:
    """The card of a demonstrations or keysteps dataset, the simulator's or anyone's.

    Args:
        dataset: what it is about.
        facts: what :func:`read_facts` says of it, where that is known already.
        license: by the Hub's name for it; None where none is given.

    Raises:
        LlakeyError: if the dataset has no instruction column.
    """
    require_instructions(dataset)
    facts = facts or read_facts(dataset)
    data = DatasetCardData(
        license=license,
        task_categories=["robotics"],
        tags=TAGS,
        configs=[{"config_name": "default", "data_files": "data/*/*.parquet"}],
    )
    return DatasetCard.from_template(
        data,
        template_str=packaged(TEMPLATE),
        repo_id=dataset.repo_id,
        kind="demonstrations" if facts.dense else "keysteps",
        episodes=dataset.meta.total_episodes,
        frames=dataset.meta.total_frames,
        fps=dataset.fps,
        robot=dataset.meta.robot_type or "not given",
        megabytes=sum(file.stat().st_size for file in Path(dataset.root).rglob("*") if file.is_file()) / 1e6,
        facts=_in_markdown(facts),
        columns=[
            (key, feature["dtype"], " x ".join(str(size) for size in feature["shape"]))
            for key, feature in dataset.features.items()
        ],
        named=list(_named(dataset.features)),
        grammar=_about_grammar(facts),
        policy="llakey" if schema.cameras_of(dataset.features, depth=True) else "llakey_command",
        record=read_record(dataset.root) if (dataset.root / RECORD).exists() else None,
        versions={
            "lerobot": metadata.version("lerobot"),
            "llakey": metadata.version("lerobot_policy_llakey"),
            "dataset": dataset.meta.info.codebase_version,
        },
        license=license,
        most=_MOST,
        fewer=_FEWER,
    )


def _named(features: Any) -> Iterator[tuple[str, list[str]]]:
    for key in (schema.STATE, schema.VELOCITY):
        names = (features.get(key) or {}).get("names")
        if isinstance(names, list | tuple):
            yield key, [str(name) for name in names]


def _about_grammar(facts: CardFacts) -> str:
    if facts.grammar.is_free:
        return "Any sentence is an instruction here."
    wordings = [template.texts[0] for template in facts.grammar.templates.values()]
    shown = "; ".join(f"`{wording}`" for wording in wordings)
    return f"Instructions follow {facts.grammar.name}, which stands in the instruction column's `info`: {shown}."


def _in_markdown(facts: CardFacts) -> CardFacts:
    """The same facts with texts that break neither a table nor a list."""
    return replace(
        facts,
        tasks=[(_line(text), count) for text, count in facts.tasks],
        instructions=[(_line(text), segments, frames) for text, segments, frames in facts.instructions],
        sequences=[(tuple(map(_line, texts)), count) for texts, count in facts.sequences],
    )


def _line(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;") or "(empty)"
