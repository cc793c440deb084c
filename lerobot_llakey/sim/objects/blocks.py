"""Blocks, and where they go: pads, a frame to insert them into, and bays with a roof to slide them under."""

from __future__ import annotations

import mujoco

_COLOURS = {
    "red": (0.85, 0.10, 0.10),
    "yellow": (0.95, 0.85, 0.10),
    "purple": (0.50, 0.10, 0.60),
    "orange": (1.00, 0.50, 0.05),
    "blue": (0.10, 0.25, 0.90),
    "green": (0.10, 0.65, 0.20),
}
_STONE = (0.45, 0.47, 0.50, 1.0)
BLOCK = 0.02
"""Half the edge of a block, metres."""
PAD = 0.034
"""Half the edge of a pad, metres."""
_HOLE, _RIM, _RIM_HEIGHT = 0.029, 0.006, 0.009
"""Half the frame's opening, half its walls' thickness and half their height, metres."""
_ROOF_EDGE = 0.005
ROOF_HEIGHT, SHELTER = 0.052, 0.05
"""A shelter's roof begins 5 mm behind its centre, at this height; half its width. Metres."""
_BOX = mujoco.mjtGeom.mjGEOM_BOX


def add_block(spec: mujoco.MjSpec, colour: str) -> None:
    """Add the free body "{colour}_block"."""
    block = spec.worldbody.add_body(name=f"{colour}_block", pos=(0, 0, 1))
    block.add_freejoint()
    block.add_geom(type=_BOX, size=(BLOCK,) * 3, mass=0.1, friction=(0.6, 0.01, 0.0001), rgba=(*_COLOURS[colour], 1))


def add_pad(spec: mujoco.MjSpec, colour: str) -> None:
    """Add the body "{colour}_target": a flat square on the table."""
    pad = spec.worldbody.add_body(name=f"{colour}_target")
    pad.add_geom(type=_BOX, size=(PAD, PAD, 0.002), pos=(0, 0, 0.002), rgba=(*_COLOURS[colour], 1))


def add_frame(spec: mujoco.MjSpec, colour: str) -> None:
    """Add the body "{colour}_target": four low walls around a hole that a block fits in."""
    frame = spec.worldbody.add_body(name=f"{colour}_target")
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        along = _HOLE + 2 * _RIM
        frame.add_geom(
            type=_BOX,
            size=(_RIM if x else along, _RIM if y else along, _RIM_HEIGHT),
            pos=(x * (_HOLE + _RIM), y * (_HOLE + _RIM), _RIM_HEIGHT),
            rgba=(*_COLOURS[colour], 1),
        )


def add_bay(spec: mujoco.MjSpec, colour: str) -> None:
    """Add the body "{colour}_target": a square under a shelter, flush with the table so that blocks slide onto it."""
    bay = spec.worldbody.add_body(name=f"{colour}_target")
    bay.add_geom(type=_BOX, size=(PAD, PAD, 0.001), rgba=(*_COLOURS[colour], 1), contype=0, conaffinity=0)
    add_shelter(bay)


def add_shelter(body: mujoco.MjsBody) -> None:
    """A roof on three walls, open towards the robot (-x), over the rear part of a block at the body's origin."""
    wall, height = 0.004, ROOF_HEIGHT / 2
    middle, depth = (_ROOF_EDGE + SHELTER) / 2, (SHELTER - _ROOF_EDGE) / 2
    body.add_geom(type=_BOX, size=(depth, SHELTER, 0.002), pos=(middle, 0, ROOF_HEIGHT + 0.002), rgba=_STONE)
    body.add_geom(type=_BOX, size=(wall, SHELTER, height), pos=(SHELTER - wall, 0, height), rgba=_STONE)
    for side in (-1, 1):
        body.add_geom(
            type=_BOX,
            size=(depth / 2, wall, height),
            pos=(middle + depth / 2, side * (SHELTER - wall), height),
            rgba=_STONE,
        )
