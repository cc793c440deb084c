"""A person at the wheel: the hierarchical policy in the simulator, watched, corrected and redirected in words."""
