"""Rows of an episode are written as LeRobot would have written them."""

from pathlib import Path

import datasets
import numpy as np
import pyarrow.parquet as pq
from lerobot.datasets.feature_utils import get_hf_features_from_features

from lerobot_llakey.datasets.image_dataset import ImageDatasetWriter

FEATURES = {
    "number": {"dtype": "float32", "shape": (1,), "names": None},
    "vector": {"dtype": "float32", "shape": (3,), "names": None},
    "matrix": {"dtype": "float32", "shape": (2, 3), "names": None},
    "flag": {"dtype": "bool", "shape": (1,), "names": None},
    "text": {"dtype": "string", "shape": (1,), "names": None},
}


def test_columns_of_any_shape_are_written_as_the_library_of_datasets_writes_them(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    frames = [
        {
            "number": rng.random(1, dtype=np.float32),
            "vector": rng.random(3, dtype=np.float32),
            "matrix": rng.random((2, 3), dtype=np.float32),
            "flag": np.array([bool(index % 2)]),
            "text": f"step {index}",
            "task": "count",
        }
        for index in range(4)
    ]
    with ImageDatasetWriter("local/x", tmp_path / "x", 10, FEATURES) as writer:
        writer.add_episode(frames)
        features = get_hf_features_from_features(writer.meta.features)
    written = pq.read_table(next((tmp_path / "x" / "data").rglob("*.parquet")))
    columns = {key: [frame[key] for frame in frames] for key in ("vector", "matrix", "text")}
    columns |= {key: [frame[key].item() for frame in frames] for key in ("number", "flag")}
    columns |= {"frame_index": range(4), "index": range(4), "timestamp": np.arange(4, dtype=np.float32) / 10}
    columns |= dict.fromkeys(("episode_index", "task_index"), [0] * 4)
    expected = datasets.Dataset.from_dict({key: list(columns[key]) for key in features}, features=features)
    pq.write_table(expected.with_format("arrow")[:], tmp_path / "expected.parquet")
    expected = pq.read_table(tmp_path / "expected.parquet")
    assert written.schema.equals(expected.schema, check_metadata=True)
    for name in expected.column_names:
        assert written[name].to_pylist() == expected[name].to_pylist(), name
