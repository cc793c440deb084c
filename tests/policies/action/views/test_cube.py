"""One scale along all axes, whatever the workspace."""

import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.action.views.cube import UnitCube

FLAT = [[0.1, 1.3], [-0.4, 0.4], [0.0, 0.3]]


def test_the_cube_of_a_cube_is_itself():
    cube = UnitCube(schema.WORKSPACE)
    assert cube.edge == 1.0 and torch.equal(cube.corner, torch.tensor(schema.WORKSPACE)[:, 0])


def test_a_metre_is_as_long_along_every_axis():
    cube = UnitCube(FLAT)
    assert cube.edge == pytest.approx(1.2)
    corners = torch.tensor(FLAT).T  # (2, 3)
    places = cube.to_unit(corners)
    assert places.min() > -1e-6 and places.max() < 1 + 1e-6
    assert torch.allclose(places.mean(dim=0), torch.full((3,), 0.5), atol=1e-6)
    assert torch.allclose(places[1] - places[0], (corners[1] - corners[0]) / 1.2, atol=1e-6)
    assert torch.allclose(cube.from_unit(places), corners, atol=1e-6)


def test_a_crop_is_a_cube_around_its_centre():
    cube = UnitCube(FLAT)
    centre = torch.tensor([[0.7, 0.1, 0.2]])
    low, extent = cube.crop(cube.to_unit(centre), 0.2)
    assert torch.allclose(cube.from_unit(low), centre - 0.1, atol=1e-6)
    assert torch.allclose(cube.from_unit(low + extent), centre + 0.1, atol=1e-6)
