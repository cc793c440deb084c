"""A page with a moment of every task, as people and as the policies see it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.sim.cameras import CameraRig
from lerobot_llakey.sim.expert import demonstrate
from lerobot_llakey.sim.simulation import Simulation
from lerobot_llakey.sim.tasks import make_task

_SIDE = 192
"""Pixels of a policy camera's picture on the page; people's picture is as high and 4:3."""
_FONT, _WHITE, _BLACK = cv2.FONT_HERSHEY_SIMPLEX, (255, 255, 255), (0, 0, 0)


def contact_sheet(tasks: Sequence[str], seed: int, actions: int = 2, detailed: bool = True) -> np.ndarray:
    """Draw the page: a row for each task, with the skill instruction on it.

    Args:
        tasks: their names.
        seed: scene seed of all rows.
        actions: of the expert before the picture is taken.
        detailed: whether people's picture shows the robot's detailed meshes.

    Returns:
        (rows, columns, 3) uint8 RGB.
    """
    page = np.concatenate([_row(task, seed, actions, detailed) for task in tasks])
    for index, camera in enumerate(("viewer", *schema.CAMERAS)):
        left = _SIDE * 4 // 3 + _SIDE * (index - 1) if index else 0
        cv2.putText(page, camera.replace("_", " "), (left + 6, len(page) - 6), _FONT, 0.4, _WHITE, 1, cv2.LINE_AA)
    return page


def _row(task: str, seed: int, actions: int, detailed: bool) -> np.ndarray:
    simulation = Simulation(make_task(task), detailed)
    world = simulation.world
    rig = CameraRig(world.model, schema.IMAGE_SIZE)
    simulation.reset(seed)
    for _ in demonstrate(simulation, actions):
        pass
    views = rig.render_all(world.data)
    people = cv2.resize(rig.render_for_people(world.data), (_SIDE * 4 // 3, _SIDE), interpolation=cv2.INTER_AREA)
    rig.close()
    policy = [cv2.resize(views[name].rgb, (_SIDE, _SIDE), interpolation=cv2.INTER_NEAREST) for name in schema.CAMERAS]
    row = np.concatenate([people, *policy], axis=1)
    words = f"{simulation.task.name}: {simulation.task.description}"
    for colour, thickness in ((_BLACK, 3), (_WHITE, 1)):
        cv2.putText(row, words, (6, 16), _FONT, 0.45, colour, thickness, cv2.LINE_AA)
    return row
