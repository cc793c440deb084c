"""The dataset card, and pushing a dataset to the Hub with it."""

from __future__ import annotations

from collections import Counter
from importlib import resources
from pathlib import Path

import numpy as np
from huggingface_hub import DatasetCard, DatasetCardData
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.datasets.parts import RECORD, read_record
from lerobot_llakey.errors import LlakeyError

TEMPLATE = "llakey_demonstrations.md"
_TAGS = ["LeRobot", "llakey", "robotics", "keyframes"]


def template() -> str:
    """The card's template: beside the package in a clone, inside it once installed."""
    package = resources.files("lerobot_llakey")
    inside = package / "dataset_cards" / TEMPLATE
    if inside.is_file():
        return inside.read_text(encoding="utf-8")
    return (Path(str(package)).parent / "dataset_cards" / TEMPLATE).read_text(encoding="utf-8")


def make_card(dataset: LeRobotDataset) -> DatasetCard:
    """The card of a demonstrations or keysteps dataset.

    Raises:
        LlakeyError: if the dataset has no instruction column.
    """
    if schema.INSTRUCTION not in dataset.features:
        raise LlakeyError(
            f"Expected demonstrations or keysteps with {schema.INSTRUCTION}, got {dataset.repo_id} without; annotate "
            "it first."
        )
    has_videos = bool(dataset.meta.video_keys)
    data = DatasetCardData(
        license="apache-2.0",
        task_categories=["robotics"],
        tags=_TAGS,
        configs=[{"config_name": "default", "data_files": "data/*/*.parquet"}],
    )
    columns = [
        (key, feature["dtype"], " x ".join(str(size) for size in feature["shape"]))
        for key, feature in dataset.features.items()
    ]
    record = read_record(dataset.root) if (dataset.root / RECORD).exists() else None
    return DatasetCard.from_template(
        data,
        template_str=template(),
        repo_id=dataset.repo_id,
        kind="demonstrations" if has_videos else "keysteps",
        episodes=dataset.meta.total_episodes,
        frames=dataset.meta.total_frames,
        fps=dataset.fps,
        robot=dataset.meta.robot_type or "not given",
        instructions=_instruction_counts(dataset),
        skills=[str(name) for name in dataset.meta.tasks.index],
        columns=columns,
        record=record,
    )


def _instruction_counts(dataset: LeRobotDataset) -> list[tuple[str, int]]:
    """How many frames are led by each instruction, the most frequent first."""
    texts = dataset.hf_dataset.with_format("numpy")[schema.INSTRUCTION]
    return Counter(str(text) for text in np.asarray(texts)).most_common()


def push(root: Path, repo_id: str, *, private: bool = False) -> str:
    """Push a dataset with its card to the Hub.

    Args:
        root: its folder.
        repo_id: user/name.
        private: whether to hide it.

    Returns:
        Its address.
    """
    dataset = open_dataset(repo_id, root)
    card = make_card(dataset)
    dataset.push_to_hub(private=private, tags=_TAGS[1:])
    card.push_to_hub(repo_id, repo_type="dataset")
    return f"https://huggingface.co/datasets/{repo_id}"
