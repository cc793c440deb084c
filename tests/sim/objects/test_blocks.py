"""Blocks fit where they are to go."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.sim.objects.blocks import BLOCK, ROOF_HEIGHT, SHELTER, add_bay, add_block, add_frame
from lerobot_llakey.sim.scene import base_spec


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = base_spec()
    add_block(spec, "red")
    add_frame(spec, "purple")
    add_bay(spec, "orange")
    spec.body("purple_target").pos = (0.5, 0.2, 0)
    spec.body("orange_target").pos = (0.5, -0.2, 0)
    return spec.compile()


def settled(model: mujoco.MjModel, position: tuple[float, float, float]) -> np.ndarray:
    data = mujoco.MjData(model)
    data.qpos[-7:] = (*position, 1, 0, 0, 0)
    for _ in range(250):
        mujoco.mj_step(model, data)
    return data.body("red_block").xpos.copy()


@pytest.mark.parametrize("beside", [0.0, 0.008])
def test_a_block_falls_through_the_frame_onto_the_table(model: mujoco.MjModel, beside: float) -> None:
    assert settled(model, (0.5 + beside, 0.2, 0.05))[2] == pytest.approx(BLOCK, abs=0.002)


def test_a_block_beside_the_hole_stays_on_the_frame(model: mujoco.MjModel) -> None:
    assert settled(model, (0.5 + 2 * BLOCK, 0.2, 0.06))[2] > BLOCK + 0.004


def test_a_block_fits_under_the_roof_and_not_through_it(model: mujoco.MjModel) -> None:
    assert settled(model, (0.5, -0.2, BLOCK + 0.001))[2] == pytest.approx(BLOCK, abs=0.002)
    assert settled(model, (0.5 + SHELTER / 2, -0.2, 0.1))[2] > ROOF_HEIGHT
