"""The arm: its model, kinematics, paths, and how it holds things."""
