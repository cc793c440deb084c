"""Words on a frame can be read and leave the picture between them alone."""

import numpy as np
import pytest

from lerobot_llakey.rollout.captions import annotate_frame


@pytest.mark.parametrize("size", [(480, 640), (120, 160)])
def test_words_stand_in_the_bands(size: tuple[int, int]) -> None:
    frame = np.full((*size, 3), 90, dtype=np.uint8)
    written = annotate_frame(frame, "close the red jar", "grasp the lid")
    band = round(0.13 * size[0])
    assert (frame == 90).all(), "the given frame is not changed"
    assert (written[band:-band] == 90).all()
    assert written[:band].max() > 200 and written[-band:].max() > 200


def test_the_instruction_and_the_outcome_are_shown() -> None:
    frame = np.zeros((240, 320, 3), dtype=np.uint8)
    pictures = [
        annotate_frame(frame, "task", "grasp the lid"),
        annotate_frame(frame, "task", "release the lid"),
        annotate_frame(frame, "task", "release the lid", outcome=True),
        annotate_frame(frame, "task", "release the lid", outcome=False),
    ]
    assert len({picture.tobytes() for picture in pictures}) == 4


def test_long_texts_fit() -> None:
    frame = np.zeros((240, 320, 3), dtype=np.uint8)
    written = annotate_frame(frame, "grasping the lid, lift it from the table and use it to seal the olive jar", "x")
    assert not written[:, -5:].any(), "nothing is cut at the right edge"
