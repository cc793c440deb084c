"""LLaKey for LeRobot: importing this package registers its environment and its policies with LeRobot."""

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig

__all__ = ["LlakeyCommandConfig"]
