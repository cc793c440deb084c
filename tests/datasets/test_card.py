"""The dataset card: what it says, and that pushing pushes it."""

import pytest
from huggingface_hub import DatasetCard
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets import card
from lerobot_llakey.datasets.plan import Targets


def test_the_card_of_demonstrations_names_columns_skills_and_seeds(collected: Targets) -> None:
    dataset = LeRobotDataset("me/demonstrations", root=collected.demonstrations)
    text = str(card.make_card(dataset))
    assert text.startswith("---\nlicense: apache-2.0") and "# me/demonstrations" in text
    assert f"| frames | {len(dataset)} |" in text and "| episodes | 3 |" in text
    assert "| simulated tasks | open_drawer |" in text and "split val" in text
    for key in schema.dataset_features():
        assert f"| `{key}` |" in text
    for task in dataset.meta.tasks.index:
        assert f"- {task}\n" in text
    assert f"- {dataset[0][schema.INSTRUCTION]} (" in text
    assert "{{" not in text and "{%" not in text


def test_the_card_of_keysteps_says_so(collected: Targets) -> None:
    dataset = LeRobotDataset("me/keysteps", root=collected.keysteps)
    text = str(card.make_card(dataset))
    assert "(*keysteps*)" in text and f"| samples | {len(dataset)} |" in text


def test_pushing_pushes_the_dataset_and_then_our_card(collected: Targets, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[str, object]] = []
    monkeypatch.setattr(
        LeRobotDataset, "push_to_hub", lambda self, private, tags: calls.append((self.repo_id, private))
    )
    monkeypatch.setattr(DatasetCard, "push_to_hub", lambda self, repo_id, repo_type: calls.append((repo_id, repo_type)))
    assert collected.keysteps is not None
    address = card.push(collected.keysteps, "me/keysteps", private=True)
    assert address.endswith("/me/keysteps")
    assert calls == [("me/keysteps", True), ("me/keysteps", "dataset")]
