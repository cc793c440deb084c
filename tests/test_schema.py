"""The data contract holds what it promises."""

import pytest

from lerobot_llakey import schema


def test_seed_ranges_are_disjoint() -> None:
    ranges = list(schema.SEED_RANGES.values())
    assert all(a.stop <= b.start or b.stop <= a.start for i, a in enumerate(ranges) for b in ranges[i + 1 :])


def test_scene_seed_refuses_unknown_splits_and_indices() -> None:
    assert schema.scene_seed("val", 3) in schema.SEED_RANGES["val"]
    with pytest.raises(ValueError, match="Expected a split"):
        schema.scene_seed("holdout", 0)
    with pytest.raises(ValueError, match="Expected an episode index"):
        schema.scene_seed("test", -1)


def test_columns_are_named_and_sized() -> None:
    features = schema.dataset_features({"front": (48, 64), "wrist": (32, 32)}, dtype="image")
    assert features[schema.image_key("front")]["shape"] == (48, 64, 3)
    assert features[schema.depth_key("wrist")]["shape"] == (32, 32, 1)
    assert features[schema.depth_key("wrist")]["info"]["is_depth_map"]
    assert features[schema.intrinsics_key("front")]["names"] == ["fx", "fy", "cx", "cy"]
    assert features[schema.extrinsics_key("front")]["names"] == list(schema.POSE_NAMES)
    assert {len(feature["shape"]) for key, feature in features.items() if "images" not in key} == {1}
    assert len(features[schema.ACTION]["names"]) == schema.ACTION_DIM == 9
    assert schema.ACTION_NAMES[schema.GRIPPER] == "gripper_open"
    assert schema.HAND_NAMES[schema.GRIPPER] == "gripper_opening"
    assert schema.ACTION_NAMES[schema.IGNORE_COLLISION] == "ignore_collision"


def test_no_text_of_a_dataset_is_an_observation() -> None:
    texts = [key for key, feature in schema.dataset_features().items() if feature["dtype"] == "string"]
    assert set(schema.TEXTS) <= set(texts)
    assert not [key for key in texts if key.startswith("observation.")]


def test_other_arms_have_other_numbers() -> None:
    features = schema.dataset_features({}, (*schema.HAND_NAMES, "elbow"), ("elbow_velocity",))
    assert features[schema.STATE]["shape"] == (9,) and features[schema.VELOCITY]["names"] == ["elbow_velocity"]
    assert schema.cameras_of(features) == ()


def test_cameras_come_in_the_order_of_the_features_and_those_with_depth_are_told() -> None:
    features = schema.dataset_features({"wrist": (8, 8), "a_depth": (8, 8), "front": (8, 8)})
    assert schema.cameras_of(schema.dataset_features()) == schema.CAMERAS
    del features[schema.depth_key("front")]
    assert "front" in schema.cameras_of(features)
    assert schema.cameras_of(features, depth=True)[0] == "wrist"
    del features[schema.extrinsics_key("wrist")]
    assert "wrist" not in schema.cameras_of(features, depth=True)
