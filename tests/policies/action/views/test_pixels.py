import torch

from lerobot_llakey.policies.action.views.pixels import (
    GROUNDED_CHANNELS,
    PLAIN_CHANNELS,
    grounded_pixels,
    plain_pixels,
)
from lerobot_llakey.policies.action.views.renderer import splat
from lerobot_llakey.policies.action.views.scene import Scene

VIEWS = ("top", "front", "side")
SIZE = 64


def make_scene(points, lift=0.0, effector=(0.5, 0.5, 0.5)):
    count = len(points)
    return Scene(
        points=torch.tensor(points),
        colours=torch.linspace(0.2, 0.9, 3 * count).view(count, 3),
        rows=torch.zeros(count, dtype=torch.int64),
        base=torch.tensor([[0.0, 0.0, lift]]),
        effector=torch.tensor([effector]),
        condition=torch.randn(1, 16),
        words=torch.randn(1, 4, 32),
        padding=torch.zeros(1, 4, dtype=torch.bool),
    )


def images(scene, low=0.0, extent=1.0, paint=grounded_pixels):
    corner = torch.full((1, 3), low)
    index = splat((scene.points - low) / extent, scene.rows, 1, VIEWS, SIZE)
    return paint(scene, index, corner, extent, VIEWS, torch.float32)[0], index[0]


def test_a_pixel_shows_its_point():
    scene = make_scene([[0.3, 0.6, 0.2], [0.8, 0.1, 0.9]])
    pixels, index = images(scene)
    assert pixels.shape == (3, SIZE, SIZE, GROUNDED_CHANNELS)
    for view, (row, column, depth) in enumerate(((0, 1, 2), (2, 1, 0), (2, 0, 1))):
        for point in range(2):
            pixel = pixels[view][index[view] == point][0]
            place = scene.points[point]
            assert torch.allclose(pixel[:3], scene.colours[point])
            assert pixel[3] == 1
            expected = torch.stack((place[depth], place[depth], place[row], place[column])) - 0.5
            assert torch.allclose(pixel[4:8], expected, atol=0.5 / 64 + 1e-6)
    assert (pixels[index < 0][:, :6] == 0).all()


def test_a_crop_knows_where_it_is():
    scene = make_scene([[0.50, 0.55, 0.45]])
    pixels, index = images(scene, low=0.4, extent=0.2)
    pixel = pixels[0][index[0] == 0][0]
    assert torch.allclose(pixel[4:8], torch.tensor([-0.25, -0.05, 0.0, 0.05]), atol=0.2 / 64)


def test_heights_are_told_from_the_base():
    plain, index = images(make_scene([[0.3, 0.6, 0.2]]))
    lifted, moved = images(make_scene([[0.3, 0.6, 0.3]], lift=0.1))
    for view in range(3):
        before, after = plain[view][index[view] == 0][0], lifted[view][moved[view] == 0][0]
        assert torch.allclose(before[5:8], after[5:8], atol=1.01 / 64)


def test_the_end_effector_is_marked_unless_it_is_unknown_or_out_of_view():
    marked, _ = images(make_scene([[0.3, 0.6, 0.2]], effector=(0.25, 0.75, 0.5)))
    for view, (row, column) in enumerate(((0.25, 0.75), (0.5, 0.75), (0.5, 0.25))):
        best = torch.stack(torch.unravel_index(marked[view, ..., 8].argmax(), (64, 64)))
        assert (best - torch.tensor([row * 64, column * 64])).abs().max() <= 1
    for effector in ((torch.nan,) * 3, (5.0, 5.0, 5.0)):
        blank, _ = images(make_scene([[0.3, 0.6, 0.2]], effector=effector))
        assert (blank[..., 8] == 0).all()


def test_a_plain_pixel_tells_its_place_in_the_cube_its_colour_and_its_depth():
    scene = make_scene([[0.50, 0.55, 0.45]])
    pixels, index = images(scene, low=0.4, extent=0.2, paint=plain_pixels)
    assert pixels.shape == (3, SIZE, SIZE, PLAIN_CHANNELS)
    place, colour = torch.tensor([0.0, 0.5, -0.5]), scene.colours[0] * 2 - 1
    for view, depth in enumerate((2, 0, 1)):
        pixel = pixels[view][index[view] == 0][0]
        assert torch.allclose(pixel[:7], torch.cat((place, colour, place[depth, None])), atol=1e-5)
    assert (pixels[index < 0][:, :7] == 0).all()


def test_a_plain_pixel_tells_which_view_row_and_column_it_is():
    pixels, _ = images(make_scene([[0.5, 0.5, 0.5]]), paint=plain_pixels)
    assert pixels[:, 0, 0, 7].tolist() == [-1.0, 0.0, 1.0]
    assert pixels[1, -1, 0, 8:].tolist() == [1.0, -1.0]
    assert pixels[1, 0, -1, 8:].tolist() == [-1.0, 1.0]
