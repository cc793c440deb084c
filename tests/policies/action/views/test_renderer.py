import pytest
import torch

from lerobot_llakey.policies.action.views.renderer import VIEWS, gather_pixels, project, splat


def brute_force(points, view, size):
    row, column, depth, greatest = VIEWS[view]
    image = torch.full((size, size), -1)
    nearest = torch.full((size, size), float("inf"))
    for index, point in enumerate(points.tolist()):
        r, c = int(point[row] * size), int(point[column] * size)
        d = -point[depth] if greatest else point[depth]
        if d < nearest[r, c]:
            nearest[r, c], image[r, c] = d, index
    return image


@pytest.mark.parametrize("view", list(VIEWS))
def test_the_nearest_point_is_shown(view):
    points = torch.rand(600, 3, generator=torch.Generator().manual_seed(0))
    rows = torch.arange(600) % 2
    index = splat(points, rows, 2, [view], 8)
    for row in range(2):
        alone = brute_force(points[row::2], view, 8)
        assert torch.equal(index[row, 0], torch.where(alone < 0, -1, 2 * alone + row))


def test_points_outside_the_cube_are_not_drawn():
    points = torch.tensor([[0.5, 0.5, 1.2], [0.2, 0.2, 0.5], [-0.1, 0.8, 0.5], [float("nan")] * 3])
    index = splat(points, torch.zeros(4, dtype=torch.int64), 1, ["top"], 10)[0, 0]
    assert index[2, 2] == 1
    assert (index >= 0).sum() == 1


def test_radius_widens_points_and_keeps_nearer_ones_in_front():
    points = torch.tensor([[0.55, 0.55, 0.2], [0.55, 0.65, 0.9]])
    index = splat(points, torch.zeros(2, dtype=torch.int64), 1, ["top"], 10, radius=1)[0, 0]
    assert (index >= 0).sum() == 12
    assert (index == 1).sum() == 9
    assert index[4, 4] == 0


def test_gathered_values_are_zero_where_nothing_is_seen():
    index = torch.tensor([[[[1, -1], [0, 1]]]])
    values = torch.tensor([[2.0], [3.0]])
    assert gather_pixels(values, index)[0, 0, ..., 0].tolist() == [[3.0, 0.0], [2.0, 3.0]]


def test_a_point_projects_into_the_pixel_that_shows_it():
    point = torch.rand(1, 3, generator=torch.Generator().manual_seed(2))
    views = list(VIEWS)
    index = splat(point, torch.zeros(1, dtype=torch.int64), 1, views, 16)
    spots = (project(point, views) * 16).long()[0]
    for view in range(len(views)):
        assert (index[0, view] >= 0).nonzero().tolist() == [spots[view].tolist()]
