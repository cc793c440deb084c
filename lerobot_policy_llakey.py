"""The module that LeRobot's plug-in discovery imports: it has the distribution's name and brings in the package."""

import lerobot_llakey  # noqa: F401
