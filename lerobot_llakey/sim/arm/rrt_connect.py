"""RRT-Connect (Kuffner and LaValle, 2000) in joint space.

OMPL's Python bindings seed their samplers once a process, so a plan would depend on the plans before it; this one
is a function of its generator alone, which keeps a seed's episode the same in every process.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_EXTEND = 0.4
_RESOLUTION = 0.08


class _Tree:
    def __init__(self, root: np.ndarray) -> None:
        self.nodes: list[np.ndarray] = [root]
        self.parents: list[int] = [-1]

    def nearest(self, joints: np.ndarray) -> int:
        return int(np.argmin(np.linalg.norm(np.stack(self.nodes) - joints, axis=1)))

    def add(self, joints: np.ndarray, parent: int) -> int:
        self.nodes.append(joints)
        self.parents.append(parent)
        return len(self.nodes) - 1

    def branch(self, index: int) -> list[np.ndarray]:
        """Nodes from the given one to the root."""
        branch = []
        while index >= 0:
            branch.append(self.nodes[index])
            index = self.parents[index]
        return branch


def rrt_connect(
    start: np.ndarray,
    goal: np.ndarray,
    limits: np.ndarray,
    is_free: Callable[[np.ndarray], bool],
    rng: np.random.Generator,
    iterations: int = 400,
    shortcuts: int = 40,
) -> np.ndarray | None:
    """A collision-free joint path, shortened by random shortcuts.

    Args:
        start: (D,) joint angles in radians.
        goal: (D,) joint angles in radians.
        limits: (D, 2) lower and upper joint limits.
        is_free: whether a configuration (D,) is free of collisions.
        rng: the only source of randomness.
        iterations: samples tried before giving up.
        shortcuts: pairs of points between which a straight path is tried afterwards.

    Returns:
        (N, D) path from start to goal, or None.
    """
    if _segment_is_free(start, goal, is_free):
        return np.stack((start, goal))
    trees = [_Tree(start), _Tree(goal)]
    for iteration in range(iterations):
        growing, other = trees[iteration % 2], trees[1 - iteration % 2]
        sample = rng.uniform(limits[:, 0], limits[:, 1])
        reached = _extend(growing, sample, is_free)
        if reached is None:
            continue
        target = growing.nodes[reached]
        while (last := _extend(other, target, is_free)) is not None:
            if np.allclose(other.nodes[last], target):
                path = growing.branch(reached)[::-1] + other.branch(last)[1:]
                return _shortcut(path if iteration % 2 == 0 else path[::-1], is_free, rng, shortcuts)
    return None


def _extend(tree: _Tree, target: np.ndarray, is_free: Callable[[np.ndarray], bool]) -> int | None:
    nearest = tree.nearest(target)
    origin = tree.nodes[nearest]
    offset = target - origin
    distance = np.linalg.norm(offset)
    if distance < 1e-9:
        return nearest
    joints = target if distance <= _EXTEND else origin + offset * (_EXTEND / distance)
    return tree.add(joints, nearest) if _segment_is_free(origin, joints, is_free) else None


def _segment_is_free(start: np.ndarray, end: np.ndarray, is_free: Callable[[np.ndarray], bool]) -> bool:
    count = max(1, int(np.ceil(np.abs(end - start).max() / _RESOLUTION)))
    return all(is_free(start + fraction * (end - start)) for fraction in np.arange(1, count + 1) / count)


def _shortcut(
    path: list[np.ndarray], is_free: Callable[[np.ndarray], bool], rng: np.random.Generator, tries: int
) -> np.ndarray:
    for _ in range(tries):
        if len(path) < 3:
            break
        first, last = sorted(rng.choice(len(path), size=2, replace=False))
        if last - first > 1 and _segment_is_free(path[first], path[last], is_free):
            path = path[: first + 1] + path[last:]
    return np.stack(path)
