"""The target that the settings ask for."""

from __future__ import annotations

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.pose_text import PoseText
from lerobot_llakey.policies.command.targets.action import ActionTarget
from lerobot_llakey.policies.command.targets.instruction import InstructionTarget


def make_target(config: LlakeyCommandConfig) -> InstructionTarget | ActionTarget:
    """The target of some settings."""
    if config.target == "action":
        return ActionTarget(PoseText(config.action_bins, config.box))
    return InstructionTarget(config.instructions)
