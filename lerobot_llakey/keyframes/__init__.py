"""Keyframe discovery on any recorded trajectory, simulated or real.

A keyframe (key state) is a frame at which a basic action has just been completed. Which frames those are, a choice of
rules says (:mod:`lerobot_llakey.keyframes.rules`).
"""
