"""The commander that the settings ask for."""

from __future__ import annotations

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander
from lerobot_llakey.policies.hierarchy.commanders.fixed_list import ListCommander
from lerobot_llakey.policies.hierarchy.commanders.oracle import OracleCommander
from lerobot_llakey.policies.hierarchy.commanders.policy import PolicyCommander
from lerobot_llakey.policies.hierarchy.commanders.task import TaskCommander
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig


def build_commander(config: LlakeyConfig, command: LlakeyCommandPolicy | None) -> Commander:
    """Who commands under these settings.

    Args:
        config: of the hierarchical policy.
        command: its command policy; None where another commands.

    Raises:
        LlakeyError: if the command policy answers with poses rather than instructions.
    """
    if command is not None:
        if command.config.target != "instruction":
            raise LlakeyError(
                f"Expected a command policy with target='instruction', got target={command.config.target!r}; it acts "
                "by itself: evaluate it alone, or train one that instructs."
            )
        return PolicyCommander(command)
    if config.commander == "list":
        return ListCommander(config.instructions)
    return OracleCommander() if config.commander == "oracle" else TaskCommander()
