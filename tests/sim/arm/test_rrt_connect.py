"""RRT-Connect in a plane with a wall."""

import itertools

import numpy as np

from lerobot_llakey.sim.arm.rrt_connect import rrt_connect

LIMITS = np.array([[-2.0, 2.0], [-2.0, 2.0]])
START, GOAL = np.array([-1.0, 0.0]), np.array([1.0, 0.0])


def _free(joints: np.ndarray) -> bool:
    return bool(abs(joints[0]) > 0.2 or joints[1] > 1.0)


def test_goes_around_the_wall() -> None:
    path = rrt_connect(START, GOAL, LIMITS, _free, np.random.default_rng(0))
    assert path is not None and np.allclose(path[0], START) and np.allclose(path[-1], GOAL)
    between = [a + t * (b - a) for a, b in itertools.pairwise(path) for t in np.linspace(0, 1, 20)]
    assert all(_free(joints) for joints in between)


def test_same_generator_same_path() -> None:
    paths = [rrt_connect(START, GOAL, LIMITS, _free, np.random.default_rng(7)) for _ in range(2)]
    assert paths[0] is not None and np.array_equal(paths[0], paths[1])


def test_a_closed_wall_has_no_path() -> None:
    closed = rrt_connect(START, GOAL, LIMITS, lambda joints: abs(joints[0]) > 0.2, np.random.default_rng(0), 60)
    assert closed is None


def test_a_free_line_is_taken() -> None:
    path = rrt_connect(START, GOAL, LIMITS, lambda joints: True, np.random.default_rng(0))
    assert path is not None and len(path) == 2
