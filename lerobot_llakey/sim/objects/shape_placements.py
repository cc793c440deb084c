"""Where shapes stand around their sorter, and where there is room for a hand or for a shape."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lerobot_llakey.geometry import Pose
from lerobot_llakey.sim.objects.placements import draw_until_it_fits
from lerobot_llakey.sim.objects.shape_sorter import HALF_SIZE, PLATE_TOP
from lerobot_llakey.sim.objects.shapes import HEIGHT, SHAPES

_SORTER_X, _SORTER_Y, _HEADING = (0.42, 0.58), (-0.24, 0.24), np.deg2rad(25)
_X, _Y, _REACH = (0.32, 0.66), (-0.33, 0.33), (0.42, 0.70)
_GAP, _SORTER_GAP = 0.105, 0.082
"""Metres between the middles of shapes, and from a shape's middle to the sorter: the open hand is 12 cm wide there."""
_RADIUS = 0.03
"""Metres from a shape's middle beyond which nothing of it reaches."""
_MARGIN = 0.005
"""Metres between a finger and the sorter."""
_FINGERS = np.array([(x, side * y, 0.009) for x in (-0.011, 0.011) for y in (0.040, 0.049, 0.058) for side in (-1, 1)])
"""Points under the fingertips of an open hand, in the tool's frame, metres."""


def layout(rng: np.random.Generator) -> tuple[Pose, np.ndarray]:
    """Pose of the sorter and (5, 2) positions of the shapes around it, with room for the hand at each.

    Raises:
        LlakeyError: if no draw leaves room for all.
    """
    return draw_until_it_fits(lambda: _draw_layout(rng), "a sorter and its shapes")


def _draw_layout(rng: np.random.Generator) -> tuple[Pose, np.ndarray] | None:
    centre = (rng.uniform(*_SORTER_X), rng.uniform(*_SORTER_Y), 0.0)
    sorter = Pose(np.array(centre), Rotation.from_euler("z", rng.uniform(-_HEADING, _HEADING)).as_quat())
    positions = np.empty((0, 2))
    for position in np.column_stack((rng.uniform(*_X, 200), rng.uniform(*_Y, 200))):
        if _is_free(position, positions, sorter):
            positions = np.vstack((positions, position))
        if len(positions) == len(SHAPES):
            return sorter, rng.permutation(positions)
    return None


def free_positions(near: np.ndarray, others: np.ndarray, sorter: Pose) -> np.ndarray:
    """The free positions on the table, those nearest to a point first.

    Args:
        near: (2,) the point; itself where it is free.
        others: (N, 2) middles of the other shapes.
        sorter: pose of the sorter.

    Returns:
        (M, 2) metres; the point alone where no position is free.
    """
    grid = np.stack(np.meshgrid(np.arange(*_X, 0.02), np.arange(*_Y, 0.02)), axis=-1).reshape(-1, 2)
    positions = np.vstack((near, grid[np.argsort(np.linalg.norm(grid - near, axis=1))]))
    free = [position for position in positions if _is_free(position, others, sorter)]
    return np.array(free or [near])


def has_room(hand: Pose, others: np.ndarray, sorter: Pose) -> bool:
    """Whether the fingers of an open hand at a pose stand on nothing.

    Args:
        hand: the tool's pose.
        others: (N, 3) origins of the other shapes.
        sorter: pose of the sorter.
    """
    tips = hand.apply(_FINGERS)
    low_others = others[others[:, 2] + HEIGHT > tips[:, 2].min()]
    apart = np.linalg.norm(tips[:, None, :2] - low_others[None, :, :2], axis=2)
    above = tips[:, 2].min() > PLATE_TOP
    return bool((apart > _RADIUS).all() and (above or _beside(tips, sorter).min() > _MARGIN))


def over_sorter(point: np.ndarray, sorter: Pose) -> bool:
    """Whether a point (3,) is above or in the sorter."""
    return bool(_beside(point[None], sorter)[0] <= 0.0)


def _is_free(position: np.ndarray, others: np.ndarray, sorter: Pose) -> bool:
    return bool(
        _REACH[0] < np.linalg.norm(position) < _REACH[1]
        and (np.linalg.norm(others - position, axis=1) > _GAP).all()
        and _beside(np.array((*position, 0.0))[None], sorter)[0] > _SORTER_GAP
    )


def _beside(points: np.ndarray, sorter: Pose) -> np.ndarray:
    """(N,) horizontal distance in metres of points (N, 3) from the sorter."""
    outside = np.abs(sorter.inverse().apply(points)[:, :2]) - HALF_SIZE
    return np.linalg.norm(np.maximum(outside, 0.0), axis=1)
