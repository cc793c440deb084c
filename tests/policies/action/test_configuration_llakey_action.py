import pytest
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import get_policy_class

from fakes_action import small_config
from lerobot_llakey import schema
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy


def test_the_policy_is_found_by_its_name():
    assert get_policy_class("llakey_action") is LlakeyActionPolicy


def test_settings_survive_saving(tmp_path):
    config = small_config(condition_on="both", workspace=[[0.0, 0.8], [-0.4, 0.4], [0.0, 0.8]])
    config.save_pretrained(tmp_path)
    loaded = PreTrainedConfig.from_pretrained(tmp_path)
    assert loaded.condition_on == "both"
    assert loaded.workspace == config.workspace
    assert loaded.views == config.views


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"condition_on": "words"}, "condition_on out of"),
        ({"dtype": "int8"}, "dtype out of 'auto', 'bfloat16', 'float32', got 'int8'"),
        ({"design": "rvt3"}, "design out of 'small', 'rvt', 'rvt2', got 'rvt3'"),
        ({"stages": 3}, "stages out of 1, 2, got 3"),
        ({"rotation": "euler"}, "rotation out of 'bins', 'sequential_bins', 'sixd'"),
        ({"rotation_frames": ["view", "wall"]}, r"rotation_frames out of view, hand, base, got \['view', 'wall'\]"),
        ({"rotation_frames": []}, "rotation_frames to name at least one"),
        ({"proprioception": "all"}, "proprioception out of 'pose', 'gripper'"),
        ({"view_size": 100}, "multiple of 16 for design 'small', got 100; try 96"),
        ({"design": "rvt", "patch_size": 11, "view_size": 224}, "multiple of 11 for design 'rvt', got 224; try 220"),
        ({"design": "rvt2", "view_size": 112, "transformer_heads": 6}, "divide token_width, got 6 and 512"),
        ({"workspace": [[0, 1], [1, 0], [0, 1]]}, "low, high"),
        ({"views": ["top", "below"]}, "views out of"),
        ({"views": ["front", "back"]}, "x, y and z"),
        ({"views": ["side", "top", "front"]}, "order top, front, side, which the weights follow, got side, top, front"),
        ({"views": ["top", "top", "front"]}, "each of views once, got 'top' more than once"),
        ({"cameras": ["front", "front"]}, "each of cameras once, got 'front' more than once"),
        ({"workspace": "table"}, "pairs in metres or 'auto', got 'table'"),
        ({"crop_size": 0.0}, "crop_size to be a number above 0, got 0.0"),
        ({"crop_size": 1e9}, "crop_size, within the workspace's longest edge, to be a number from 0 to 1, got"),
        ({"crop_noise": 0.11}, "crop_noise, within half of crop_size, to be a number from 0 to 0.1, got 0.11"),
        ({"splat_radius": [0, 1000]}, r"splat_radius\[1\] to be a whole number from 0 to 16, got 1000"),
        ({"splat_radius": [-1, 1]}, r"splat_radius\[0\] to be a whole number from 0 to 16, got -1"),
        ({"workspace": [[0, 1], [0, float("inf")], [0, 1]]}, r"workspace \(y\) to be a number from -10 to 10, got inf"),
        ({"workspace": [[0, 1], [0, 1]]}, "three"),
        ({"text_width": 30}, "text_width to be a multiple of 4, got 30"),
        ({"rotation_blur": -1.0}, "rotation_blur to be a number from 0 to 180, got -1.0"),
    ],
)
def test_wrong_settings_are_named(setting, message):
    with pytest.raises(ValueError, match=message):
        small_config(**setting)


def test_missing_cameras_are_named():
    config = small_config()
    del config.input_features[schema.depth_key("wrist")]
    with pytest.raises(ValueError, match=r"Expected the features observation\.images\.wrist_depth"):
        config.validate_features()


def test_the_hand_must_be_among_the_states_names():
    config = small_config(state_names=["shoulder", "elbow"])
    with pytest.raises(ValueError, match=r"the hand's 'x' among the names of observation\.state, got only shoulder"):
        config.validate_features()


def test_actions_of_another_shape_are_refused():
    config = small_config()
    config.output_features["action"].shape = (7,)
    with pytest.raises(ValueError, match=r"actions of 9 numbers.*\(7,\)"):
        config.validate_features()


def test_what_is_not_read_is_dropped_from_the_input_features():
    config = small_config()
    config.narrow_features()
    assert sorted(config.input_features) == sorted(config.required_features())


def test_the_timestep_needs_its_column():
    config = small_config(use_timestep=True)
    config.validate_features()
    config.narrow_features()
    assert schema.STEP in config.input_features
    del config.input_features[schema.STEP]
    with pytest.raises(ValueError, match=r"column observation\.step .* for policy\.use_timestep, got none"):
        config.validate_features()


@pytest.mark.parametrize("share", [-0.1, 1.0])
def test_a_jitter_that_leaves_no_colour_is_refused(share):
    with pytest.raises(ValueError, match=f"colour_jitter to be a number from 0 and below 1, got {share}"):
        small_config(colour_jitter=share)
