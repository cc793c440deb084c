import numpy as np
import pytest

from lerobot_llakey.policies.hierarchy.motion import distance, turned


def test_measures_between_states_and_actions() -> None:
    state, action = np.zeros(15, dtype=np.float32), np.zeros(9, dtype=np.float32)
    state[6] = 1.0
    action[:7] = 0.03, 0.0, 0.04, 0.0, 0.0, -np.sin(np.pi / 8), -np.cos(np.pi / 8)
    assert distance(state, action) == pytest.approx(0.05)
    assert turned(state, action) == pytest.approx(45.0, abs=0.01)
    assert turned(action, action) == pytest.approx(0.0, abs=0.1)
