from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.workspace import MARGIN, keyframe_box


def test_the_box_holds_all_keyframes_with_a_margin(tmp_path: Path) -> None:
    dataset = fake_keysteps(tmp_path / "keysteps")
    places = np.array(dataset.hf_dataset.with_format(None)[schema.ACTION])[:, :3]
    box = np.array(keyframe_box(dataset.meta))
    assert (box[:, 0] <= places.min(axis=0) - MARGIN).all() and (box[:, 1] >= places.max(axis=0) + MARGIN).all()
    assert np.abs(box - np.stack((places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN), axis=1)).max() <= 0.0101


def test_a_dataset_that_is_not_here_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="keyframe positions in the column action of 'far/away'"):
        keyframe_box(SimpleNamespace(root=tmp_path, repo_id="far/away"))
