"""Parts are loaded with care: the right kind, the right weights, their own learning rates."""

from pathlib import Path

import pytest

from fakes_action import small_config
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.parts import load_part, parameter_groups
from lerobot_llakey.saved.weights import check_keys


@pytest.fixture
def action() -> LlakeyActionPolicy:
    return LlakeyActionPolicy(small_config())


def test_a_part_comes_back(action: LlakeyActionPolicy, tmp_path: Path) -> None:
    action.save_pretrained(tmp_path)
    loaded = load_part(LlakeyActionPolicy, tmp_path, "cpu")
    for name, value in action.state_dict().items():
        assert value.equal(loaded.state_dict()[name]), name


def test_other_kinds_and_empty_folders_are_refused(action: LlakeyActionPolicy, tmp_path: Path) -> None:
    action.save_pretrained(tmp_path / "action")
    with pytest.raises(ValueError, match="Expected a checkpoint of type 'llakey_command'"):
        load_part(LlakeyCommandPolicy, tmp_path / "action", "cpu")
    with pytest.raises(FileNotFoundError, match=r"Expected a checkpoint folder or a Hub name, .* where none was found"):
        load_part(LlakeyActionPolicy, tmp_path / "nothing" / "here", "cpu")


def test_keys_must_fit(tmp_path: Path) -> None:
    check_keys(tmp_path, [], [])
    with pytest.raises(ValueError, match="1 missing"):
        check_keys(tmp_path, ["action.head"], [])


def test_rates_follow_the_parts_own_preset(action: LlakeyActionPolicy) -> None:
    preset = action.config.get_optimizer_preset()
    groups = parameter_groups(action, 0.5)
    assert {group["lr"] for group in groups} == {0.5 * preset.lr}
    assert {group["weight_decay"] for group in groups} == {preset.weight_decay, 0.0}
    assert sum(len(group["params"]) for group in groups) == len(list(action.parameters()))
