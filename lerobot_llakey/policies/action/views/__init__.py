"""The input of a stage: the scene in the unit cube, its rendering, and the channels of a rendered pixel.

Nothing in this room is learned.
"""
