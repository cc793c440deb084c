"""What the rules look at."""

import numpy as np
import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.keyframes.motion import Motion, smoothed


@pytest.mark.parametrize(
    ("poses", "openings", "message"),
    [
        (np.zeros((5, 7)), np.zeros(4), "T >= 2"),
        (np.zeros((1, 7)), np.zeros(1), "T >= 2"),
        (np.full((5, 7), np.nan), np.zeros(5), "finite"),
    ],
)
def test_bad_motions_are_refused(poses: np.ndarray, openings: np.ndarray, message: str) -> None:
    with pytest.raises(LlakeyError, match=message):
        Motion(poses, openings, 10)


def test_spikes_go_and_noise_shrinks() -> None:
    noisy = np.random.default_rng(0).normal(0, 1, (200, 1))
    noisy[50] += 100
    calm = smoothed(noisy, 20, 0.4)
    assert calm.std() < 0.6 and np.abs(calm).max() < 3
