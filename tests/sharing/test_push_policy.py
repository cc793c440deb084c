"""A policy goes to the Hub with a card: its own, or one that is made; and not at all if it would not load."""

import json
import shutil
from pathlib import Path

import pytest
import torch
from huggingface_hub import HfApi, ModelCard
from safetensors.torch import load_file, save_file

from hub_server import Hub
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sharing.push_policy import push_policy

SHIPPED = Path(__file__).parents[2] / "checkpoints/llakey_small"
NAME = "me/llakey"


@pytest.fixture
def checkpoint(tmp_path: Path) -> Path:
    """The shipped checkpoint, composed of two, without the card that someone wrote for it."""
    return Path(shutil.copytree(SHIPPED, tmp_path / "llakey", ignore=shutil.ignore_patterns("README.md")))


def card_of(hub: Hub) -> ModelCard:
    return ModelCard(hub.repos["models", NAME].head["README.md"][0].decode())


def test_a_composed_policy_arrives_with_a_card_and_its_results(hub: Hub, api: HfApi, checkpoint: Path) -> None:
    (checkpoint / "train_config.json").write_text(
        json.dumps({"dataset": {"repo_id": "me/keysteps"}, "steps": 8000, "batch_size": 16, "seed": 1})
    )
    (checkpoint / "rng_state.bin").write_bytes(b"of this machine")
    results = checkpoint.parent / "eval_info.json"
    figures = {"pc_success": 50.0, "n_episodes": 4}
    results.write_text(json.dumps({"per_task": [], "per_group": {"close_jar": figures}, "overall": figures}))
    address, private = push_policy(NAME, checkpoint, results, api=api)
    repo = hub.repos["models", NAME]
    assert address == f"{hub.url}/{NAME}" and private and repo.private and not repo.tags
    files = {path.name for path in checkpoint.iterdir()} - {"rng_state.bin"}
    assert set(repo.head) == files | {"README.md", ".gitattributes"}
    assert all(repo.head[name][0] == (checkpoint / name).read_bytes() for name in files)
    card = card_of(hub)
    assert {"LeRobot", "llakey"} <= set(card.data.tags) and card.data.library_name == "lerobot"
    assert card.data.datasets == "me/keysteps" and card.data.license == "apache-2.0"
    assert "| `close_jar` | 4 | 50 % |" in card.text and "--policy.path=me/llakey" in card.text
    assert "8,000 of 16, seed 1" in card.text and "{{" not in card.text
    count = sum(weight.numel() for weight in load_file(checkpoint / "model.safetensors").values())
    assert f"| parameters | {count:,} |" in card.text


def test_a_card_that_someone_wrote_is_kept(hub: Hub, api: HfApi) -> None:
    push_policy(NAME, SHIPPED, private=False, api=api)
    card = card_of(hub)
    assert (
        not hub.repos["models", NAME].private
        and card.text.strip() == ModelCard.load(SHIPPED / "README.md").text.strip()
    )
    assert {"LeRobot", "llakey"} <= set(card.data.tags)


def test_an_interrupted_push_goes_on(hub: Hub, api: HfApi, checkpoint: Path) -> None:
    hub.uploads_left = 0
    with pytest.raises(LlakeyError, match="give the same command again"):
        push_policy(NAME, checkpoint, api=api)
    hub.uploads_left = None
    push_policy(NAME, checkpoint, api=api)
    push_policy(NAME, checkpoint, api=api)
    assert len(hub.uploads) == 1 and "No evaluation results are known." in card_of(hub).text


def test_what_would_not_load_stays_here(hub: Hub, api: HfApi, checkpoint: Path) -> None:
    with pytest.raises(LlakeyError, match=r"Expected a checkpoint folder at .*nowhere, found none"):
        push_policy(NAME, checkpoint / "nowhere", api=api)
    with pytest.raises(LlakeyError, match=r"Expected the results of an evaluation at .*nowhere.json"):
        push_policy(NAME, checkpoint, checkpoint / "nowhere.json", api=api)
    (checkpoint / "policy_preprocessor.json").rename(checkpoint / "other.json")
    with pytest.raises(LlakeyError, match=r"Expected a checkpoint with policy_preprocessor.json"):
        push_policy(NAME, checkpoint, api=api)
    (checkpoint / "other.json").rename(checkpoint / "policy_preprocessor.json")
    weights = load_file(checkpoint / "model.safetensors")
    name = next(name for name, weight in weights.items() if weight.is_floating_point() and weight.ndim)
    save_file(weights | {name: torch.full_like(weights[name], torch.nan)}, checkpoint / "model.safetensors")
    with pytest.raises(LlakeyError, match="got NaN or infinity in"):
        push_policy(NAME, checkpoint, api=api)
    (checkpoint / "config.json").write_text('{"type": "act"}')
    with pytest.raises(LlakeyError, match=r"Expected a checkpoint of llakey, .* got one of act"):
        push_policy(NAME, checkpoint, api=api)
    assert not hub.requests
