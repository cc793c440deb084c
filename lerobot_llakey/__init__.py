"""LLaKey for LeRobot: importing this package registers its environment and its policies with LeRobot.

Only settings are imported here; networks and the simulator load when LeRobot asks for them by name.
"""

import logging
import sys

if sys.argv and sys.argv[0].rpartition("/")[2].startswith("llakey"):
    # The llakey command and its worker processes: without FFmpeg LeRobot reads videos through PyAV, and would warn of
    # it in sixty lines at every start.
    logging.getLogger("lerobot.utils.import_utils").setLevel(logging.ERROR)

from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.saved.guard import guard_loading
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig

guard_loading(__name__)  # a checkpoint comes from a stranger, however LeRobot is made to load it

__all__ = ["LlakeyActionConfig", "LlakeyCommandConfig", "LlakeyConfig", "LlakeySimConfig"]
