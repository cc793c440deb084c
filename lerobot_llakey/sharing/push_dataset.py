"""A dataset goes to the Hub: looked over first, with its card, and with the tag that LeRobot looks for."""

from __future__ import annotations

from pathlib import Path

from huggingface_hub import HfApi
from lerobot.utils.constants import HF_LEROBOT_HOME

from lerobot_llakey.checks.dataset import find, needs_all, say
from lerobot_llakey.datasets.card import make_card, require_instructions
from lerobot_llakey.datasets.card_facts import read_facts
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.sharing.upload import Shipment, require_repo_id, upload

FILES = ("data/*", "meta/*", "videos/*")
"""What of a dataset's folder belongs to it."""
SIMULATED_LICENSE = "apache-2.0"


def push_dataset(
    repo_id: str,
    root: Path | None = None,
    *,
    private: bool | None = None,
    license: str | None = None,
    api: HfApi | None = None,
) -> tuple[str, bool]:
    """Push a dataset with its card, or what of it is not there yet.

    Args:
        repo_id: its name on the Hub, user/name.
        root: its folder; by default that of LeRobot's home folder.
        private: whether only you see it; by default whatever holds a recording of something real is private.
        license: by the Hub's name for it; by default that of this package for simulated data and none for recordings.
        api: client of the Hub.

    Returns:
        Its address, and whether it was pushed as private.

    Raises:
        MissingFileError: if there is no such dataset.
        LlakeyError: if ``llakey check`` refuses it, or the Hub does.
    """
    require_repo_id(repo_id)
    dataset = open_dataset(repo_id, root or HF_LEROBOT_HOME / repo_id)
    require_instructions(dataset)
    say(find(dataset.meta, needs_all(dataset.features)), repo_id)
    facts = read_facts(dataset)
    private = not facts.simulated if private is None else private
    card = make_card(dataset, facts, license or (SIMULATED_LICENSE if facts.simulated else None))
    version = str(dataset.meta.info.codebase_version)
    return upload(Shipment(Path(dataset.root), repo_id, "dataset", FILES, str(card), private, version), api), private
