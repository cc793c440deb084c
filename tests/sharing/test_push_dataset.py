"""A dataset goes to the Hub with its card and LeRobot's tag, and not at all if it would not train."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from huggingface_hub import DatasetCard, HfApi
from lerobot.datasets.dataset_metadata import CODEBASE_VERSION

from fakes import fake_keysteps
from fakes_recordings import fake_recording
from hub_server import Hub
from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sharing.push_dataset import push_dataset

NAME = "me/keysteps"


def change(root: Path, key: str, new: Callable[[list], list]) -> None:
    """Give a column of a dataset other values."""
    for path in (root / "data").rglob("*.parquet"):
        table = pq.read_table(path)
        place = table.column_names.index(key)
        field = table.schema.field(place)
        pq.write_table(table.set_column(place, field, pa.array(new(table[key].to_pylist()), field.type)), path)


def test_a_dataset_arrives_whole_with_card_and_version(hub: Hub, api: HfApi, tmp_path: Path) -> None:
    root = Path(fake_keysteps(tmp_path / "keysteps", repo_id=NAME).root)
    (root / "notes.txt").write_text("mine alone")
    address, private = push_dataset(NAME, root, api=api)
    repo = hub.repos["datasets", NAME]
    assert address == f"{hub.url}/datasets/{NAME}" and not private and not repo.private
    assert repo.tags == {CODEBASE_VERSION: repo.refs["main"]}
    card = DatasetCard(repo.head["README.md"][0].decode())
    assert {"LeRobot", "llakey"} <= set(card.data.tags) and card.data.license == "apache-2.0"
    hashes = {path: hashlib.sha256(content).hexdigest() for path, (content, _) in repo.head.items()}
    for file in (file for part in ("data", "meta") for file in (root / part).rglob("*") if file.is_file()):
        assert hashes[str(file.relative_to(root))] == hashlib.sha256(file.read_bytes()).hexdigest()
    assert "notes.txt" not in repo.head


def test_a_recording_is_private_unless_it_is_said_otherwise(hub: Hub, api: HfApi, tmp_path: Path) -> None:
    root = Path(fake_keysteps(tmp_path / "keysteps", repo_id=NAME).root)
    change(root, schema.EPISODE_SEED, lambda seeds: [-1] * len(seeds))
    assert push_dataset(NAME, root, api=api)[1]
    assert hub.repos["datasets", NAME].private
    assert "licence | not given" in hub.repos["datasets", NAME].head["README.md"][0].decode()
    assert not push_dataset("me/open", root, private=False, license="cc-by-4.0", api=api)[1]
    opened = hub.repos["datasets", "me/open"]
    assert not opened.private and DatasetCard(opened.head["README.md"][0].decode()).data.license == "cc-by-4.0"


def test_what_the_check_refuses_stays_here(hub: Hub, api: HfApi, tmp_path: Path) -> None:
    root = Path(fake_keysteps(tmp_path / "keysteps", repo_id=NAME).root)
    change(root, schema.ACTION, lambda actions: [[float("nan")] * len(actions[0]), *actions[1:]])
    with pytest.raises(LlakeyError, match=f"^Expected .* in action of {NAME}, got .*nan"):
        push_dataset(NAME, root, api=api)
    with pytest.raises(LlakeyError, match="Expected demonstrations or keysteps with instruction, got"):
        push_dataset(NAME, Path(fake_recording(tmp_path / "recording", "five_joints", 1, scale=0.125).root), api=api)
    with pytest.raises(LlakeyError, match=r"Expected the folder of a dataset at .*nowhere, found none"):
        push_dataset(NAME, tmp_path / "nowhere", api=api)
    assert not hub.requests
