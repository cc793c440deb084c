"""Time in a world: the steps of its physics, and who watches them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from lerobot_llakey.sim.world import World


class Clock:
    """Lets time go by in a world.

    Args:
        world: the scene.
        before_step: called with the world before each step of the physics.
    """

    def __init__(self, world: World, before_step: Callable[[World], None]) -> None:
        self.world, self.timestep = world, float(world.model.opt.timestep)
        self._before_step = before_step
        self._observer: Callable[[], None] | None = None
        self._observer_steps = 1
        self._steps = 0

    def observe(self, callback: Callable[[], None] | None, fps: float = 10.0) -> None:
        """Call ``callback`` at ``fps`` simulated frames a second from now on; None stops it."""
        self._observer, self._observer_steps = callback, max(1, round(1 / (fps * self.timestep)))
        self._steps = 0

    @contextmanager
    def unobserved(self) -> Iterator[None]:
        """Simulate without the observer, for what will be taken back."""
        observer, steps = self._observer, self._steps
        self._observer = None
        try:
            yield
        finally:
            self._observer, self._steps = observer, steps

    def advance(self, seconds: float) -> None:
        """Simulate for a while with the present targets of the arm."""
        for _ in range(max(1, round(seconds / self.timestep))):
            self.step()

    def step(self) -> None:
        """Simulate one time step."""
        self._before_step(self.world)
        mujoco.mj_step(self.world.model, self.world.data)
        self._steps += 1
        if self._observer is not None and self._steps % self._observer_steps == 0:
            self._observer()

    def warnings(self) -> list[str]:
        """What MuJoCo has found wrong since it was last asked: it goes on from a reset state, or with less contacts."""
        counts = self.world.data.warning.number
        found = [mujoco.mjtWarning(int(kind)).name.removeprefix("mjWARN_") for kind in np.flatnonzero(counts)]
        counts[:] = 0
        return found
