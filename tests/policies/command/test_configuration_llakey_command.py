import pytest
from lerobot.configs import PreTrainedConfig

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


def test_settings_survive_saving(small_config, tmp_path):
    small_config.words, small_config.instructions = ["a"], ["grasp a"]
    small_config.save_pretrained(tmp_path)
    loaded = PreTrainedConfig.from_pretrained(tmp_path)
    assert isinstance(loaded, LlakeyCommandConfig)
    assert loaded == small_config


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"history": 2}, "`history` out of 0, 1, got 2"),
        ({"dtype": "float8"}, "got 'float8'"),
        ({"proprioception": "all"}, "`proprioception` out of none, pose, got 'all'"),
        ({"hold_above": 0.0}, "hold_above to be a number above 0, got 0.0"),
        ({"cameras": ["front", "front"]}, "each of cameras once, got 'front'"),
        ({"max_new_tokens": 1}, "max_new_tokens to be a whole number from 2 to 4096, got 1"),
        ({"words": ["the", "red"]}, "words in alphabetical order, .* got the, red"),
        ({"words": ["red", "red"]}, "each of words once, got 'red'"),
        (
            {"instructions": ["dance", "grasp the lid"]},
            r"the grammar 'basic', got 1 outside it \('dance'\)",
        ),
        ({"instructions": [7]}, r"instructions as a list of texts, got \[7\]"),
        ({"text_width": 250}, "text_heads that divide text_width, got 4 and 250"),
        ({"workspace": [[0, 1], [1, 0], [0, 1]]}, "low, high"),
        ({"image_size": 100}, "multiple of `patch_size`, got 100 and 16"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(ValueError, match=message):
        LlakeyCommandConfig(device="cpu", **settings)
