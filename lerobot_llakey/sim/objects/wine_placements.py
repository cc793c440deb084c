"""Where a wine rack and three bottles are, so that the arm gets to each of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.objects.wine import BOTTLE_RADIUS

LYING_GRIP = 0.075
"""Metres from a lying bottle's bottom to where a hand takes it."""
SIDE = np.deg2rad(65)
"""Heading of the hand that takes a standing bottle: from the bottle's right side, for the wrist bends no farther."""
_DISTANCE, _DIRECTION, _RIGHT = (0.43, 0.64), (-0.60, 0.55), (-0.60, -0.15)
"""Where lying bottles are taken: metres from the base, and radians to the left of straight ahead; the latter also for
the standing bottle."""
_RACK_HALF, _WIDEST, _WIDEST_GREEN = np.array((0.078, 0.13)), 0.32, 0.29
"""Half the rack's length and width, and how far to the side a lying and the standing bottle may reach, metres."""
_ALONG, _ACROSS = np.array(((0, 0.04, 0.08, 0.12, 0.165, LYING_GRIP, LYING_GRIP), (0,) * 5 + (-0.05, 0.05)))
"""Of a lying bottle, points on its axis and where the fingers come down beside it, metres from its bottom."""
_GAP, _RACK_GAP, _HAND_GAP, _HAND_GAP_ALONG, _ARM = 0.055, 0.235, 0.14, 0.09, 0.28
"""Metres between things; from the rack's middle to the standing bottle; from a lying bottle to the standing one, for
the hand's width and thickness; length of the hand and wrist beside the standing bottle."""
_DRAWS = 64


@dataclass(frozen=True)
class _Planar:
    """A position on the table: a point (2,) in metres and a heading in radians."""

    position: np.ndarray
    yaw: float = 0.0

    def local(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 2) of the base frame, seen from here."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return (points - self.position) @ np.array(((cosine, -sine), (sine, cosine)))


def draw_placements(rng: np.random.Generator) -> tuple[Pose, ...]:
    """Where the rack and the red, green and yellow bottles are; a fixed arrangement where no draw in 100 fits."""
    for _ in range(100):
        y, distance = rng.uniform(0.02, 0.16), rng.uniform(0.50, 0.57)
        position = np.array((np.sqrt(distance**2 - y**2), y))
        rack = _Planar(position, np.arctan2(*position[::-1]) + rng.uniform(-0.2, 0.05))
        greens = _positions(rng, _RIGHT)
        fit = (rack.local(greens)[:, 1] < -_RACK_GAP) & (np.abs(greens[:, 1]) < _WIDEST_GREEN)
        if not fit.any():
            continue
        green = greens[fit.argmax()]
        red = _draw_lying(rng, rack, green, 0.0, 0.5, None)
        yellow = None if red is None else _draw_lying(rng, rack, green, np.pi, 0.4, red)
        if red is not None and yellow is not None:
            break
    else:
        rack, green = _Planar(np.array((0.53, 0.10)), 0.1), np.array((0.60, -0.20))
        red, yellow = _Planar(np.array((0.42, -0.20)), 0.0), _Planar(np.array((0.5, -0.08)), 3.1)
    upright = Rotation.from_euler("z", rack.yaw).as_quat()
    return (
        Pose(_on_table(rack.position), upright),
        lying(red.position, red.yaw),
        Pose(_on_table(green)),
        lying(yellow.position, yellow.yaw),
    )


def lying(position: np.ndarray, yaw: float) -> Pose:
    """A bottle that lies on the table, its neck along ``yaw``, where a hand takes it at ``position`` (2,)."""
    turned = Rotation.from_euler("ZY", (yaw, np.pi / 2))
    return Pose(_on_table(position, BOTTLE_RADIUS) - turned.apply((0, 0, LYING_GRIP)), turned.as_quat())


def _on_table(position: np.ndarray, height: float = 0.0) -> np.ndarray:
    return np.array((*position, height))


def _positions(rng: np.random.Generator, direction: tuple[float, float]) -> np.ndarray:
    """(_DRAWS, 2) positions within the arm's reach."""
    distance, angle = rng.uniform(*_DISTANCE, _DRAWS), rng.uniform(*direction, _DRAWS)
    return distance[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))


def _draw_lying(
    rng: np.random.Generator, rack: _Planar, green: np.ndarray, turn: float, spread: float, other: _Planar | None
) -> _Planar | None:
    """A lying bottle that touches nothing, where a hand gets to it and to the standing one; None if no draw does.

    Args:
        rng: the episode's.
        rack: the rack.
        green: (2,) position of the standing bottle.
        turn: heading of the neck seen from the rack, give or take ``spread``.
        spread: radians.
        other: the other lying bottle.
    """
    positions, yaws = _positions(rng, _DIRECTION), rack.yaw + turn + rng.uniform(-spread, spread, _DRAWS)
    points = _footprints(positions, yaws)
    fit = np.abs(points[..., 1]).max(axis=1) < _WIDEST
    beyond = np.maximum(np.abs(rack.local(points)) - _RACK_HALF, 0.0)
    fit &= np.linalg.norm(beyond, axis=-1).min(axis=1) > _GAP
    fit &= np.linalg.norm(points - green, axis=-1).min(axis=1) > _GAP
    # The hand that takes the lying bottle, wider than its fingers, and the one that comes to the standing one.
    axes = np.column_stack((np.cos(yaws), np.sin(yaws)))
    along = np.abs(((green - positions) * axes).sum(axis=1))
    across = np.abs(((green - positions) * axes[:, ::-1] * (-1, 1)).sum(axis=1))
    fit &= (along > _HAND_GAP_ALONG) | (across > _HAND_GAP)
    forward, sideways = np.moveaxis(_Planar(green, SIDE).local(points), -1, 0)
    fit &= ~((np.abs(sideways) < _GAP) & (forward < 0) & (forward > -_ARM)).any(axis=1)
    if other is not None:
        others = _footprints(other.position[None], np.array((other.yaw,)))[0]
        fit &= np.linalg.norm(points[:, :, None] - others, axis=-1).min(axis=(1, 2)) > _GAP
    first = int(fit.argmax())
    return _Planar(positions[first], float(yaws[first])) if fit[first] else None


def _footprints(positions: np.ndarray, yaws: np.ndarray) -> np.ndarray:
    """(N, 7, 2) points of lying bottles taken at positions (N, 2), their necks along the yaws (N,)."""
    axes = np.column_stack((np.cos(yaws), np.sin(yaws)))[:, None]
    sides = axes[..., ::-1] * (-1, 1)
    return positions[:, None] + (_ALONG - LYING_GRIP)[:, None] * axes + _ACROSS[:, None] * sides
