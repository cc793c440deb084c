"""The pictures of a moment in one."""

import io

import numpy as np
from PIL import Image

from lerobot_llakey import schema
from lerobot_llakey.drive.views import jpeg, one_picture


def test_the_views_stand_in_order_below_the_humans_picture() -> None:
    pictures = {camera: np.full((32, 32, 3), 50 * place, np.uint8) for place, camera in enumerate(schema.CAMERAS)}
    whole = one_picture(pictures | {"viewer": np.full((120, 160, 3), 255, np.uint8)})
    assert whole.shape == (160, 160, 3) and (whole[:120] == 255).all()
    assert [int(whole[140, 20 + 40 * place, 0]) for place in range(4)] == [0, 50, 100, 150]


def test_a_jpeg_keeps_the_order_of_colours() -> None:
    red = np.zeros((16, 16, 3), np.uint8)
    red[..., 0] = 250
    assert np.array(Image.open(io.BytesIO(jpeg(red))))[8, 8, 0] > 200
