import pytest
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import get_policy_class

from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig


def test_is_registered_with_lerobot() -> None:
    assert PreTrainedConfig.get_choice_class("llakey") is LlakeyConfig
    assert get_policy_class("llakey").config_class is LlakeyConfig


def test_survives_saving_with_both_parts(tmp_path) -> None:
    config = LlakeyConfig(device="cpu", commander="oracle", repeat_threshold=5)
    config.command.instructions = ["grasp the lid"]
    config.action.crop_size = 0.3
    config.save_pretrained(tmp_path)
    assert PreTrainedConfig.from_pretrained(tmp_path) == config
    changed = PreTrainedConfig.from_pretrained(tmp_path, cli_overrides=["--action.view_size=64", "--commander=task"])
    assert isinstance(changed, LlakeyConfig)
    assert (changed.action.view_size, changed.action.crop_size, changed.commander) == (64, 0.3, "task")


def test_the_parts_follow_the_device() -> None:
    config = LlakeyConfig(device="cpu")
    assert config.command.device == config.action.device == "cpu"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"commander": "nobody"}, "a commander out of"),
        ({"repeat_threshold": -1}, "repeat_threshold >= 0"),
        ({"random_move_probability": 1.5}, r"random_move_probability in \[0, 1\]"),
        ({"train_command": False, "train_action": False}, "at least one part to train"),
        ({"commander": "oracle", "train_action": False}, "at least one part to train"),
        ({"fallback_instruction": "dance"}, "a basic action"),
        ({"commander": "list"}, "at least one instruction for commander='list'"),
        ({"commander": "list", "instructions": ["dance"]}, "a basic action"),
        ({"ask_again_attempts": 0}, "ask_again_attempts >= 1"),
        ({"ask_again_temperature": 0.0}, "ask_again_temperature > 0"),
        ({"still_degrees": -1.0}, "still_degrees >= 0"),
    ],
)
def test_bad_settings_are_refused_in_one_sentence(settings: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LlakeyConfig(device="cpu", **settings)
