import pytest

from lerobot_llakey.policies.hierarchy.commanders.build import build_commander
from lerobot_llakey.policies.hierarchy.commanders.fixed_list import ListCommander
from lerobot_llakey.policies.hierarchy.commanders.oracle import OracleCommander
from lerobot_llakey.policies.hierarchy.commanders.policy import PolicyCommander
from lerobot_llakey.policies.hierarchy.commanders.task import TaskCommander
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig


def test_builds_whom_the_settings_name(make_tiny) -> None:
    for name, kind in (("oracle", OracleCommander), ("task", TaskCommander)):
        assert type(build_commander(LlakeyConfig(device="cpu", commander=name), None)) is kind
    config = LlakeyConfig(device="cpu", commander="list", instructions=["grasp the lid"])
    commander = build_commander(config, None)
    assert isinstance(commander, ListCommander) and commander.instructions == ["grasp the lid"]
    policy = make_tiny()
    assert isinstance(policy.commander, PolicyCommander)
    assert policy.commander.command is policy.command


def test_a_command_policy_that_acts_by_itself_is_refused(make_tiny) -> None:
    policy = make_tiny()
    policy.command.config.target = "action"
    with pytest.raises(ValueError, match="target='instruction', got target='action'"):
        build_commander(policy.config, policy.command)
