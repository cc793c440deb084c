"""Goods are told apart by their looks and fit into the hand."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lerobot_llakey.sim.objects.groceries import GOODS, Good, add_good

WIDEST = 0.067
NAMES = ["crackers", "chocolate jello", "strawberry jello", "soup", "tuna", "spam", "coffee", "mustard", "sugar"]


def test_the_nine_goods_in_order() -> None:
    assert [good.name for good in GOODS] == NAMES
    assert GOODS[1].body == "chocolate_jello"


def test_no_two_goods_look_alike() -> None:
    looks = {(good.colour, good.label, good.round, good.size) for good in GOODS}
    assert len(looks) == len(GOODS)


@pytest.mark.parametrize("good", GOODS, ids=NAMES)
def test_the_hand_fits_around_a_good_from_two_sides(good: Good) -> None:
    assert 2 * good.size[0] <= WIDEST and 2 * good.size[1] <= WIDEST
    assert 0.03 <= 2 * good.size[2] <= 0.09


def test_half_extents() -> None:
    box, can = Good("box", (0.01, 0.02, 0.03), (0, 0, 0), (1, 1, 1), (0, 1)), GOODS[3]
    assert box.half_extent(np.array((0, -1.0, 0))) == pytest.approx(0.02)
    slanted = Rotation.from_euler("z", 0.7).apply((1.0, 0, 0))
    assert can.half_extent(slanted) == pytest.approx(can.size[0])
    assert can.half_extent(np.array((0, 0, 1.0))) == pytest.approx(can.size[2])


@pytest.mark.parametrize("good", GOODS, ids=NAMES)
def test_a_good_is_a_free_body_touched_by_its_shape_alone(good: Good) -> None:
    spec = mujoco.MjSpec()
    add_good(spec, good)
    model = spec.compile()
    assert model.nq == 7 and model.body(good.body).mass[0] == pytest.approx(0.1)
    touched = np.flatnonzero(model.geom_contype)
    assert len(touched) == 1 and model.ngeom >= 2
    kind = mujoco.mjtGeom.mjGEOM_CYLINDER if good.round else mujoco.mjtGeom.mjGEOM_BOX
    assert model.geom_type[touched[0]] == kind


@pytest.mark.parametrize("good", [good for good in GOODS if good.round], ids=lambda good: good.name)
def test_a_can_that_rolls_soon_lies_still(good: Good) -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(2, 2, 0.1))
    add_good(spec, good)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:7] = (0, 0, good.size[0], np.sqrt(0.5), np.sqrt(0.5), 0, 0)
    data.qvel[0], data.qvel[5] = 0.2, -0.2 / good.size[0]
    for _ in range(round(2.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert abs(data.qpos[0]) < 0.08 and np.abs(data.qvel).max() < 0.02
