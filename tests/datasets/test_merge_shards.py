"""Shards of a collection become what one run makes, or are refused."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from fakes import fake_keysteps
from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.collect_record import RECORD, read_record
from lerobot_llakey.datasets.digest import digest
from lerobot_llakey.datasets.merge_shards import merge_shards
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.shards import Shard


def _shard(
    root: Path, number: int, count: int = 2, episodes: int = 3, held: int | None = None, **changed: object
) -> Path:
    share = Shard(number, count).of(episodes)
    fake_keysteps(root, episodes=len(share) if held is None else held, image_size=32)
    settings = {"fps": 10} | changed | Shard(number, count).recorded(episodes)
    (root / RECORD).write_text(json.dumps({"settings": settings, "episodes": len(share), "discarded": {"bad": number}}))
    return root


@pytest.mark.parametrize("kind", ["demonstrations", "keysteps"])
def test_shards_in_any_order_become_the_dataset_of_one_run(
    kind: str, collected: Targets, settings: CollectSettings, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.getbasetemp() / "shards"
    roots = {number: (folder / f"{number}" / "demonstrations", folder / f"{number}" / "keysteps") for number in (2, 1)}
    if not folder.exists():
        for number, (demonstrations, keysteps) in roots.items():
            collect(settings, Targets(demonstrations, keysteps), 1, lambda *_: None, Shard(number, 2))
    merged, one = folder / f"merged_{kind}", getattr(collected, kind)
    merge_shards([folder / f"{number}" / kind for number in roots], merged, "local/merged")
    assert digest(merged) == digest(one)
    assert read_record(merged) == read_record(one)


def test_a_merged_dataset_is_extended_as_one_that_was_collected(
    collected: Targets, settings: CollectSettings, tmp_path: Path
) -> None:
    for number in (1, 2):
        part = Targets(None, tmp_path / f"{number}")
        collect(replace(settings, num_episodes=2), part, 1, lambda *_: None, Shard(number, 2))
    merged = Targets(None, tmp_path / "merged")
    assert merged.keysteps is not None and collected.keysteps is not None
    merge_shards([tmp_path / "1", tmp_path / "2"], merged.keysteps, "local/merged")
    collect(settings, merged, 1, lambda *_: None)
    assert digest(merged.keysteps) == digest(collected.keysteps)


def test_a_folder_of_one_shard_is_refused_to_another(settings: CollectSettings, tmp_path: Path) -> None:
    target = Targets(None, tmp_path / "keysteps")
    collect(settings, target, 1, lambda *_: None, Shard(1, 3))
    for other in (Shard(2, 3), Shard()):
        with pytest.raises(LlakeyError, match="choose another folder"):
            collect(settings, target, 1, lambda *_: None, other)


@pytest.mark.parametrize(
    ("named", "message"),
    [
        (("1",), "Expected all 2 shards, got 1 without 2/2"),
        (("1", "2", "1"), "Expected each shard once, got shard 1 in"),
        (("1", "copy", "2"), "Expected each shard once, got shard 1 in"),
        (("1", "2", "none"), "Expected shards alone, got .*none"),
        (("1", "2.parts"), "Expected finished shards, got .*2.parts"),
        (("1", "other"), "got another fps in"),
        (("1", "third"), "got another number of shards in"),
        (("1", "lacking"), "Expected 2 episodes in the shard .*lacking, got 1"),
    ],
)
def test_what_would_lose_or_double_episodes_is_refused(named: Sequence[str], message: str, tmp_path: Path) -> None:
    _shard(tmp_path / "1", 1)
    _shard(tmp_path / "2", 2)
    if "copy" in named:
        _shard(tmp_path / "copy", 1)
    if "other" in named:
        _shard(tmp_path / "other", 2, fps=30)
    if "third" in named:
        _shard(tmp_path / "third", 2, count=3)
    if "lacking" in named:
        _shard(tmp_path / "lacking", 2, held=1)
    if "none" in named:
        fake_keysteps(tmp_path / "none", episodes=1, image_size=32)
    if "2.parts" in named:
        (tmp_path / "2.parts").mkdir()
    with pytest.raises(LlakeyError, match=message):
        merge_shards([tmp_path / name for name in named], tmp_path / "merged", "local/merged")
    assert not (tmp_path / "merged").exists()


def test_what_was_discarded_is_summed(tmp_path: Path) -> None:
    merge_shards([_shard(tmp_path / "2", 2), _shard(tmp_path / "1", 1)], tmp_path / "merged", "local/merged")
    assert read_record(tmp_path / "merged") == {"settings": {"fps": 10}, "episodes": 3, "discarded": {"bad": 3}}
