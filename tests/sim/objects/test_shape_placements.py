"""Shapes stand apart, and the hand finds room beside them."""

import numpy as np
import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.sim.objects import shape_placements
from lerobot_llakey.sim.objects.shape_placements import free_positions, has_room, layout, over_sorter

SORTER = Pose(np.array((0.5, 0.0, 0.0)))


@pytest.mark.parametrize("seed", range(20))
def test_the_hand_has_room_at_every_shape(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sorter, positions = layout(rng)
    origins = np.column_stack((positions, np.zeros(len(positions))))
    for index, origin in enumerate(origins):
        hand = Pose(origin + (0, 0, 0.041), top_down(float(rng.uniform(-0.7, 0.7))))
        assert has_room(hand, np.delete(origins, index, axis=0), sorter)
        assert not over_sorter(origin, sorter)


def test_a_finger_has_no_room_on_the_sorter_or_a_shape() -> None:
    nothing = np.empty((0, 3))
    beside = Pose(np.array((0.5, 0.14, 0.041)), top_down(0.0))
    assert not has_room(beside, nothing, SORTER)
    assert has_room(Pose(beside.position, top_down(np.pi / 2)), nothing, SORTER)
    assert has_room(beside.shifted(z=0.04), nothing, SORTER)
    assert has_room(beside.shifted(y=0.05), nothing, SORTER)
    assert not has_room(beside.shifted(y=0.05), np.array(((0.5, 0.25, 0.0),)), SORTER)


def test_free_positions_begin_at_the_point_itself_where_it_is_free() -> None:
    nothing = np.empty((0, 2))
    np.testing.assert_allclose(free_positions(np.array((0.5, 0.25)), nothing, SORTER)[0], (0.5, 0.25))
    positions = free_positions(np.array((0.5, 0.05)), np.array(((0.5, 0.2),)), SORTER)
    assert (np.linalg.norm(positions - (0.5, 0.2), axis=1) > 0.1).all()
    assert not any(over_sorter(np.array((*position, 0.0)), SORTER) for position in positions)


def test_a_table_without_room_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shape_placements, "_is_free", lambda *_: False)
    with pytest.raises(LlakeyError, match="Expected room for a sorter and its shapes"):
        layout(np.random.default_rng(0))
