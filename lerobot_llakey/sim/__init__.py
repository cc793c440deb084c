"""The simulator. MuJoCo picks its OpenGL platform when first imported, so headless machines are served here."""

import ctypes.util
import os
import sys

if sys.platform == "linux" and "MUJOCO_GL" not in os.environ and not os.environ.get("DISPLAY"):
    os.environ["MUJOCO_GL"] = "egl" if ctypes.util.find_library("EGL") else "osmesa"
