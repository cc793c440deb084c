"""Columns change; all else of a dataset stays as it was."""

from pathlib import Path

import pyarrow as pa
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.datasets.rewrite import drop, rewrite


def test_columns_are_added_and_replaced(tmp_path: Path) -> None:
    before = fake_keysteps(tmp_path / "data", episodes=2, frames=3)
    rows = [before[i] for i in range(len(before))]

    def columns(table: pa.Table) -> dict[str, pa.Array]:
        return {
            schema.INSTRUCTION: pa.array(["raise the robotic arm"] * table.num_rows),
            "note": pa.array([float(i) for i in range(table.num_rows)], pa.float32()),
        }

    rewrite(tmp_path / "data", columns, {"note": {"dtype": "float32", "shape": (1,), "names": None}})
    after = LeRobotDataset(before.repo_id, root=tmp_path / "data")
    assert len(after) == len(rows)
    assert [after[i]["note"].item() for i in range(len(after))] == [float(i) for i in range(len(rows))]
    for old, new in zip(rows, (after[i] for i in range(len(after))), strict=True):
        assert new[schema.INSTRUCTION] == "raise the robotic arm"
        for key in (schema.image_key("front"), schema.extrinsics_key("front"), schema.ACTION):
            assert torch.equal(old[key], new[key])
    assert not list((tmp_path / "data").rglob("*.tmp"))


def test_dropped_columns_are_gone_and_the_rest_stays(tmp_path: Path) -> None:
    before = fake_keysteps(tmp_path / "data", episodes=2, frames=3)
    rows = [before[i] for i in range(len(before))]
    drop(tmp_path / "data", [schema.PREVIOUS_INSTRUCTION, schema.VELOCITY, "unknown"])
    after = LeRobotDataset(before.repo_id, root=tmp_path / "data")
    assert set(before.features) - set(after.features) == {schema.PREVIOUS_INSTRUCTION, schema.VELOCITY}
    assert set(before.meta.stats) - set(after.meta.stats) == {schema.VELOCITY}
    assert not [name for name in after.meta.episodes.column_names if schema.VELOCITY in name]
    for old, new in zip(rows, (after[i] for i in range(len(after))), strict=True):
        assert schema.PREVIOUS_INSTRUCTION not in new and new[schema.INSTRUCTION] == old[schema.INSTRUCTION]
        assert torch.equal(old[schema.image_key("front")], new[schema.image_key("front")])
