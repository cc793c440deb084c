"""The data contract holds what it promises."""

import pytest

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError


def test_seed_ranges_are_disjoint() -> None:
    ranges = list(schema.SEED_RANGES.values())
    assert all(a.stop <= b.start or b.stop <= a.start for i, a in enumerate(ranges) for b in ranges[i + 1 :])


def test_scene_seed_refuses_unknown_splits_and_indices() -> None:
    assert schema.scene_seed("val", 3) in schema.SEED_RANGES["val"]
    with pytest.raises(ValueError, match="Expected a split"):
        schema.scene_seed("holdout", 0)
    with pytest.raises(ValueError, match="Expected an episode index"):
        schema.scene_seed("test", -1)


def test_text_survives_encoding() -> None:
    text = "slide the red block to the orange target"
    assert schema.decode_text(schema.encode_text(text)) == text
    with pytest.raises(ValueError, match="Expected at most"):
        schema.encode_text("x" * (schema.TEXT_LENGTH + 1))


def test_columns_are_named_and_sized() -> None:
    features = schema.demonstration_features(64, 48, ("front", "wrist"))
    assert features[schema.image_key("front")]["shape"] == (64, 48, 3)
    assert features[schema.depth_key("wrist")]["info"]["is_depth_map"]
    assert features[schema.INTRINSICS]["shape"] == (2, 3, 3)
    assert len(features[schema.STATE]["names"]) == schema.STATE_DIM == 15
    velocity = features[schema.VELOCITY]["names"]
    assert len(velocity) == schema.VELOCITY_DIM == 8
    assert velocity[schema.ARM_VELOCITY] == [f"{name}_velocity" for name in schema.STATE_NAMES[schema.JOINTS]]
    assert velocity[schema.GRIPPER_VELOCITY] == "gripper_velocity"
    assert len(features[schema.ACTION]["names"]) == schema.ACTION_DIM == 9
    assert schema.ACTION_NAMES[schema.GRIPPER] == "gripper_open"
    assert schema.STATE_NAMES[schema.GRIPPER] == "gripper_opening"
    assert schema.ACTION_NAMES[schema.IGNORE_COLLISION] == "ignore_collision"


@pytest.mark.parametrize("code", [float("nan"), float("inf"), -1.0, 2.0**21, 97.5])
def test_what_is_no_code_point_is_refused(code: float) -> None:
    codes = schema.encode_text("grasp")
    codes[2] = code
    with pytest.raises(LlakeyError, match=r"code points from 0 to 1114111, got .* at place 2"):
        schema.decode_text(codes)
