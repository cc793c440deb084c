"""Solved examples for a chat model, drawn from a keysteps dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat.messages import Example
from lerobot_llakey.policies.command.chat.settings import ChatSettings
from lerobot_llakey.policies.command.images import stack_views
from lerobot_llakey.policies.command.prompt import Prompt


def draw_examples(settings: ChatSettings, views: Sequence[str], history: bool) -> list[Example]:
    """Examples of as many different instructions as there are, the same ones for the same seed.

    Args:
        settings: how many, of which dataset, and the seed.
        views: cameras that are shown, in this order.
        history: whether the question tells the instruction last commanded.

    Raises:
        LlakeyError: if the dataset is too small, or lacks the instructions or a view.
    """
    if not settings.examples:
        return []
    dataset = LeRobotDataset(str(settings.examples_repo_id), root=settings.examples_root)
    if schema.INSTRUCTION not in dataset.features:
        raise LlakeyError(
            f"Expected `chat.examples_repo_id` to name a dataset with the column {schema.INSTRUCTION!r}, got "
            f"{settings.examples_repo_id!r} without it; make one with `llakey keysteps`."
        )
    if len(dataset) < settings.examples:
        raise LlakeyError(
            f"Expected at least {settings.examples} samples in {settings.examples_repo_id!r}, got {len(dataset)}; "
            "lower chat.examples or give a larger dataset."
        )
    said = [str(text) for text in dataset.hf_dataset.with_format(None)[schema.INSTRUCTION]]
    rows = spread(said, settings.examples, np.random.default_rng(settings.examples_seed))
    return [_example(dataset[row], views, history) for row in rows]


def spread(labels: Sequence[str], count: int, rng: np.random.Generator) -> list[int]:
    """Indices of ``count`` labels in random order, no label a second time before every label was there once."""
    order = rng.permutation(len(labels)).tolist()
    times: dict[str, int] = {}
    turn = {}
    for index in order:
        turn[index] = times[labels[index]] = times.get(labels[index], -1) + 1
    return sorted(order, key=turn.__getitem__)[:count]


def _example(sample: dict[str, Any], views: Sequence[str], history: bool) -> Example:
    keys = [schema.image_key(view) for view in views]
    images = stack_views({key: sample[key][None] for key in keys if key in sample}, keys)[0]
    previous = str(sample.get(schema.PREVIOUS_INSTRUCTION, "")) if history else None
    return Example(Prompt(tuple(views), str(sample[schema.TASK]), previous), images, str(sample[schema.INSTRUCTION]))
