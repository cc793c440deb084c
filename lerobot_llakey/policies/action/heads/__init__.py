"""From heatmaps and features to the keyframe pose: the point, the rotation, the flags, their targets and losses.

A pose head is one representation of rotations; ``targets`` holds the conventions for heatmaps and angles.
"""
