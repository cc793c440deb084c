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
        ({"views": []}, "at least one camera"),
        ({"history": 2}, "`history` to be 0 or 1, got 2"),
        ({"dtype": "float8"}, "got 'float8'"),
        ({"proprioception": "all"}, "none or pose, got 'all'"),
        ({"hold_above": 0.0}, "`hold_above` above 0 radians a second, got 0.0"),
        ({"image_size": 100}, "multiple of `patch_size`, got 100 and 16"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(ValueError, match=message):
        LlakeyCommandConfig(device="cpu", **settings)
