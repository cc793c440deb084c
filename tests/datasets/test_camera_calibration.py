"""Calibration from a person's file: flat or as matrices, YAML or JSON."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.datasets.camera_calibration import read_calibration
from lerobot_llakey.errors import LlakeyError, MissingFileError

POSE = [0.9, 0.1, 0.6, *Rotation.from_euler("xyz", [2.0, 0.1, 0.3]).as_quat().tolist()]
GOOD: dict[str, Any] = {"intrinsics": [600.0, 610.0, 320.0, 240.0], "extrinsics": POSE}


def written(path: Path, content: Any) -> Path:
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_numbers_and_matrices_say_the_same(tmp_path: Path) -> None:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(POSE[3:]).as_matrix(), POSE[:3]
    matrices = {"intrinsics": [[600, 0, 320], [0, 610, 240], [0, 0, 1]], "extrinsics": matrix.tolist()}
    found = read_calibration(written(tmp_path / "c.json", {"front": GOOD, "side": matrices}), ["front", "side", "top"])
    assert set(found) == {"front", "side"}
    np.testing.assert_allclose(found["side"].intrinsics, found["front"].intrinsics)
    np.testing.assert_allclose(found["side"].extrinsics[:3], found["front"].extrinsics[:3], rtol=1e-6)
    assert abs(found["side"].extrinsics[3:] @ found["front"].extrinsics[3:]) == pytest.approx(1, abs=1e-6)
    yaml = f"front:\n  intrinsics: [600, 610, 320, 240]\n  extrinsics: {POSE}\n"
    again = read_calibration(written(tmp_path / "c.yaml", yaml), ["front"])
    np.testing.assert_array_equal(again["front"].extrinsics, found["front"].extrinsics)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"rear": GOOD}, "cameras front in .*, got rear"),
        ({}, "one entry a camera"),
        ("- 1\n- 2\n", "one entry a camera"),
        ("front: [", "YAML or JSON"),
        ({"front": {"intrinsics": [1, 2, 3, 4]}}, "of camera front .*got intrinsics; give both"),
        ({"front": GOOD | {"intrinsics": [600, 320, 240]}}, "4 or 3x3 finite numbers"),
        ({"front": GOOD | {"intrinsics": [600, "x", 320, 240]}}, "4 or 3x3 finite numbers"),
        ({"front": GOOD | {"intrinsics": [[600, 5000, 320], [0, 600, 240], [0, 0, 1]]}}, "without skew"),
        ({"front": GOOD | {"extrinsics": POSE[:6]}}, "7 or 4x4 finite numbers"),
        ({"front": GOOD | {"extrinsics": [*POSE[:3], 1, 1, 0, 0]}}, "unit quaternion.*length 1.41"),
        ({"front": GOOD | {"extrinsics": (2 * np.eye(4)).tolist()}}, "camera-to-base matrix"),
        ({"front": GOOD | {"extrinsics": np.diag([-1.0, 1, 1, 1]).tolist()}}, "camera-to-base matrix"),
    ],
)
def test_what_is_no_calibration_is_named(content: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match=message):
        read_calibration(written(tmp_path / "c.yaml", content), ["front"])


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="check --calibration"):
        read_calibration(tmp_path / "none.yaml", ["front"])
