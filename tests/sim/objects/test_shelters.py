"""Shelters cover a cup, are open towards -y, and only the cabinet has sides."""

import mujoco
import numpy as np
import pytest

from lerobot_llakey.sim.objects.shelters import SHELTER_HALF_WIDTH, add_cabinet, add_ledge


def distance(spec: mujoco.MjSpec, start: tuple[float, ...], direction: tuple[float, ...]) -> float:
    """Metres to the first surface along a ray, -1 where there is none."""
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = np.zeros(1, dtype=np.int32)
    return float(mujoco.mj_ray(model, data, np.array(start), np.array(direction), None, 1, -1, found))


@pytest.mark.parametrize("add", [add_cabinet, add_ledge])
def test_a_roof_and_a_wall_cover_what_stands_inside(add) -> None:
    spec = mujoco.MjSpec()
    add(spec, "shelter")
    assert distance(spec, (0, 0.02, 0.06), (0, 0, 1)) == pytest.approx(0.08, abs=0.002)
    assert 0.04 < distance(spec, (0, 0.02, 0.06), (0, 1, 0)) < 0.08
    assert distance(spec, (0, 0.02, 0.06), (0, -1, 0)) == -1
    beside = distance(spec, (0, 0.02, 0.06), (1, 0, 0))
    assert 0 < beside < SHELTER_HALF_WIDTH if add is add_cabinet else beside == -1
