"""Worker processes that share what they import: one process imports, the others are forked from it."""

from __future__ import annotations

import multiprocessing
import sys

_WORKERS_NEED = ("lerobot.envs.utils", "gymnasium.vector.async_vector_env", "lerobot_llakey.sim.env")
_ALSO_SHARED = ("lerobot.scripts.", "lerobot_llakey.")
_LAST = "lerobot_llakey.sim.frozen"


def share_imports() -> None:
    """Let workers of the "forkserver" kind share the memory of what they import.

    Python's fork server is a fresh process: it has no OpenGL context and no threads of PyTorch's, which do not survive
    a fork. By default it imports nothing, so that each worker takes 500 to 900 MB for PyTorch, LeRobot and MuJoCo. Here
    it imports what this process has loaded of LeRobot's scripts and of this package. No effect where a fork server
    runs already.
    """
    loaded = (name for name in list(sys.modules) if name.startswith(_ALSO_SHARED))
    multiprocessing.set_forkserver_preload(["__main__", *dict.fromkeys((*_WORKERS_NEED, *loaded)), _LAST])
