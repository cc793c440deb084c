"""Rack and bottles do not start in each other's way."""

import numpy as np
import pytest

from lerobot_llakey.sim.objects.wine_placements import LYING_GRIP, draw_placements, lying


@pytest.mark.parametrize("seed", range(50))
def test_things_keep_apart(seed: int) -> None:
    rack, red, green, yellow = draw_placements(np.random.default_rng(seed))
    axes = np.column_stack((np.zeros(9), np.zeros(9), np.linspace(0.0, 0.17, 9)))
    bottles = [bottle.apply(axes)[:, :2] for bottle in (red, green, yellow)]
    for first, second in ((0, 1), (0, 2), (1, 2)):
        gaps = np.linalg.norm(bottles[first][:, None] - bottles[second], axis=-1)
        assert gaps.min() > 0.048
    for points in bottles:
        local = rack.inverse().apply(np.column_stack((points, np.zeros(9))))
        assert (np.maximum(np.abs(local[:, :2]) - (0.078, 0.13), 0).max(axis=1) > 0.03).all()
    assert np.abs(np.concatenate(bottles)[:, 1]).max() < 0.33


@pytest.mark.parametrize("seed", range(10))
def test_each_bottle_is_in_its_state(seed: int) -> None:
    rack, red, green, yellow = draw_placements(np.random.default_rng(seed))
    forward = rack.rotation.as_matrix()[:, 0]
    necks = [bottle.rotation.as_matrix()[:, 2] for bottle in (red, green, yellow)]
    assert necks[0] @ forward > np.cos(0.51)
    assert necks[1][2] > 0.999
    assert necks[2] @ forward < -np.cos(0.41)


def test_a_lying_bottle_is_taken_at_its_position() -> None:
    bottle = lying(np.array((0.5, 0.1)), 0.3)
    assert bottle.apply(np.array((0, 0, LYING_GRIP)))[:2] == pytest.approx((0.5, 0.1))
    assert bottle.rotation.as_matrix()[:, 2] == pytest.approx((np.cos(0.3), np.sin(0.3), 0), abs=1e-9)
