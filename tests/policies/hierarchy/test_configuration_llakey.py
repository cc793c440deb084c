import math
from typing import Any, get_args, get_origin, get_type_hints

import pytest
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import get_policy_class

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
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
        ({"repeat_threshold": -1}, "repeat_threshold to be a whole number of 0 or more, got -1"),
        ({"random_move_probability": 1.5}, "random_move_probability to be a number from 0 to 1, got 1.5"),
        ({"train_command": False, "train_action": False}, "at least one part to train"),
        ({"commander": "oracle", "train_action": False}, "at least one part to train"),
        ({"fallback_instruction": "dance"}, "a basic action"),
        ({"commander": "list"}, "at least one instruction for commander='list'"),
        ({"commander": "list", "instructions": ["dance"]}, "a basic action"),
    ],
)
def test_bad_settings_are_refused_in_one_sentence(settings: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LlakeyConfig(device="cpu", **settings)


KINDS = (LlakeyConfig, LlakeyActionConfig, LlakeyCommandConfig)


def numbers_in(hint: Any) -> int:
    """How deep in lists the numbers of a type lie, 0 for a number, -1 for a type without numbers."""
    if hint in (int, float):
        return 0
    inner = [numbers_in(part) for part in get_args(hint)]
    if get_origin(hint) is dict or not inner or max(inner) < 0:
        return -1
    return max(inner) + (get_origin(hint) is list)


NUMBERS = [(kind, name, numbers_in(hint)) for kind in KINDS for name, hint in get_type_hints(kind).items()]
NUMBERS = [found for found in NUMBERS if found[2] >= 0]


def test_the_search_finds_numbers_alone_and_in_lists() -> None:
    found = {(kind.__name__, name): depth for kind, name, depth in NUMBERS}
    assert found["LlakeyActionConfig", "crop_size"] == 0 and found["LlakeyCommandConfig", "optimizer_lr"] == 0
    assert found["LlakeyActionConfig", "widths"] == 1 and found["LlakeyActionConfig", "workspace"] == 2
    assert found["LlakeyConfig", "random_move_radius"] == 0 and ("LlakeyConfig", "use_amp") not in found
    assert len(found) > 60


@pytest.mark.parametrize(("kind", "name", "depth"), NUMBERS, ids=lambda value: getattr(value, "__name__", str(value)))
def test_every_number_of_the_settings_is_held_against_sense(kind: type, name: str, depth: int) -> None:
    default = schema.WORKSPACE if name == "workspace" else getattr(kind(device="cpu"), name)
    for value in (math.nan, math.inf, -math.inf, -1e9, "7"):
        wrong: Any = value
        if depth == 1:
            wrong = [value, *default[1:]]
        elif depth == 2:
            wrong = [[value, default[0][1]], *default[1:]]
        with pytest.raises(LlakeyError, match=name):
            kind(device="cpu", **{name: wrong})
