"""Importing the package, as LeRobot's plug-in discovery does."""

import json
import subprocess
import sys

LIST = """
import json, sys
import lerobot_policy_llakey
from lerobot.configs import PreTrainedConfig
from lerobot.envs.configs import EnvConfig
names = [*PreTrainedConfig.get_known_choices(), *EnvConfig.get_known_choices()]
print(json.dumps({"choices": [name for name in names if "llakey" in name], "modules": list(sys.modules)}))
"""


def test_registers_everything_without_loading_networks_or_the_simulator() -> None:
    done = subprocess.run([sys.executable, "-c", LIST], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert sorted(found["choices"]) == ["llakey", "llakey_action", "llakey_command", "llakey_sim"]
    loaded = {name for name in found["modules"] if name in ("mujoco", "ompl", "gym_hil")}
    loaded |= {name for name in found["modules"] if name.startswith("lerobot_llakey.") and "modeling_" in name}
    assert loaded == set()
