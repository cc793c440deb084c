"""What the command policy needs of its training dataset, and the texts it learns from it."""

from __future__ import annotations

from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import Needs
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.small.tokenizer import grammar_words, known_words
from lerobot_llakey.policies.dataset_columns import tables_of, texts_of


def dataset_needs(config: LlakeyCommandConfig) -> Needs:
    """The columns read under these settings: texts, images, and the state and action if they are used."""
    columns = {schema.TASK, schema.SAMPLE_WEIGHT}
    columns |= {schema.INSTRUCTION} if config.target == "instruction" else {schema.ACTION}
    columns |= {schema.PREVIOUS_INSTRUCTION} if config.history else set()
    columns |= {schema.STATE} if config.uses_proprioception else set()
    if config.model is None and config.auxiliary_weight:
        columns |= {schema.STATE, schema.ACTION}
    return Needs(frozenset(columns), views=tuple(config.cameras), depth=False, workspace=None)


def learn_texts(config: LlakeyCommandConfig, dataset_meta: Any) -> None:
    """Add a dataset's instructions to the settings, and its words if the settings have none.

    Raises:
        LlakeyError: if the dataset has no instructions, or one is outside the grammar.
    """
    found = dataset_instructions(dataset_meta) if config.target == "instruction" else []
    config.instructions = sorted({*config.instructions, *found})
    if not config.words:
        config.words = sorted({*grammar_words(config.rules), *known_words([*dataset_tasks(dataset_meta), *found])})
    config.check_texts()


def dataset_tasks(dataset_meta: Any) -> list[str]:
    """The skill instructions of a dataset, sorted."""
    tasks = getattr(dataset_meta, "tasks", None)
    return [] if tasks is None else sorted(str(task) for task in tasks.index)


def dataset_instructions(dataset_meta: Any) -> list[str]:
    """The distinct basic instructions of a dataset, sorted; only its parquet files are read.

    Args:
        dataset_meta: a ``LeRobotDatasetMetadata``.

    Returns:
        The instructions; none if the files are not on this disk (a streamed dataset).

    Raises:
        LlakeyError: if the dataset has no ``instruction`` column.
    """
    if schema.INSTRUCTION not in dataset_meta.features:
        raise LlakeyError(
            f"Expected a dataset with the column {schema.INSTRUCTION!r}, got {dataset_meta.repo_id!r} without it; "
            "make one with `llakey keysteps`."
        )
    columns = (table.column(schema.INSTRUCTION) for table in tables_of(dataset_meta, [schema.INSTRUCTION]))
    found = {str(text) for column in columns for text in texts_of(column).dictionary.to_pylist() if text}
    return sorted(found)
