"""A policy goes to the Hub: looked over first, with a card that says what it is, how to use it and what it can do."""

from __future__ import annotations

from math import prod
from pathlib import Path
from typing import Any

from huggingface_hub import HfApi, ModelCard
from lerobot.configs import PreTrainedConfig
from lerobot.configs.train import TRAIN_CONFIG_NAME
from safetensors import safe_open

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.model_card import TAGS, TrainingRun, make_model_card
from lerobot_llakey.policies.hierarchy.results import known_results
from lerobot_llakey.saved.folder import FILES, PROCESSORS, inspect_checkpoint, read_json, read_settings, require_weights
from lerobot_llakey.saved.processors import OUR_STEPS
from lerobot_llakey.saved.weights import check_weights
from lerobot_llakey.sharing.upload import Shipment, require_repo_id, upload

_KINDS = {"llakey": LlakeyConfig, "llakey_command": LlakeyCommandConfig, "llakey_action": LlakeyActionConfig}
_CARD = "README.md"


def push_policy(
    repo_id: str,
    folder: Path,
    results: Path | None = None,
    *,
    private: bool | None = None,
    license: str | None = None,
    api: HfApi | None = None,
) -> tuple[str, bool]:
    """Push a checkpoint with its card, or what of it is not there yet.

    Args:
        repo_id: its name on the Hub, user/name.
        folder: of the checkpoint.
        results: file of an evaluation's figures; by default the ``results.json`` beside the weights, if there is one.
        private: whether only you see it; by default it is, since nobody knows here what it was trained on.
        license: by the Hub's name for it; by default the settings' own, else this package's.
        api: client of the Hub.

    Returns:
        Its address, and whether it was pushed as private.

    Raises:
        MissingFileError: if the checkpoint, a file of it or the results are missing.
        LlakeyError: if it is broken or of another kind of policy, or the Hub refuses it.
    """
    require_repo_id(repo_id)
    if not folder.is_dir():
        raise MissingFileError(f"Expected a checkpoint folder at {folder}, found none; check --policy_path.")
    kind = read_settings(folder)["type"]
    if kind not in _KINDS:
        raise LlakeyError(
            f"Expected a checkpoint of {', '.join(_KINDS)} in {folder}, got one of {kind}; push it from lerobot-train "
            "by --policy.push_to_hub=true."
        )
    inspect_checkpoint(folder, OUR_STEPS)
    check_weights(require_weights(folder))
    for name in PROCESSORS:
        read_json(folder / name)
    config: Any = PreTrainedConfig.from_pretrained(folder)
    table = known_results(None if results is None else str(results), folder)
    card = _own_card(folder, table)
    if card is None:
        card = make_model_card(config, repo_id, _run(folder), parameters=_count(folder), results=table, license=license)
    elif license is not None:
        card.data["license"] = license
    private = True if private is None else private
    return upload(Shipment(folder, repo_id, "model", FILES, str(card), private), api), private


def _own_card(folder: Path, table: str | None) -> ModelCard | None:
    """The card that someone wrote for the checkpoint, with our tags and the table of results."""
    file = folder / _CARD
    if not file.is_file():
        return None
    with reading(file, "model card"):
        card = ModelCard.load(file)
    card.data.tags = list(dict.fromkeys([*TAGS, *(card.data.tags or [])]))
    if table is not None and table not in card.text:
        card.text = f"{card.text.rstrip()}\n\n## Evaluation\n\n{table}\n"
    return card


def _run(folder: Path) -> TrainingRun:
    """What LeRobot wrote of the training run, which a composed checkpoint lacks."""
    if not (folder / TRAIN_CONFIG_NAME).is_file():
        return TrainingRun()
    settings = read_json(folder / TRAIN_CONFIG_NAME, "training run's settings")
    dataset = settings.get("dataset") or {}
    return TrainingRun(dataset.get("repo_id"), settings.get("steps"), settings.get("batch_size"), settings.get("seed"))


def _count(folder: Path) -> int:
    """Parameters of a checkpoint."""
    with safe_open(require_weights(folder), framework="pt") as file:
        return sum(prod(file.get_slice(name).get_shape()) for name in file.keys())  # noqa: SIM118 - not a mapping
