"""Going back to an earlier moment: everything of a simulation that acting changes."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from lerobot_llakey.sim.simulation import Simulation

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


@dataclass(frozen=True)
class Snapshot:
    """A moment of a simulation, to which it can go back exactly.

    Attributes:
        state: MuJoCo's integration state.
        model: the model's arrays that differ from the pristine scene's.
        rng: state of the world's generator.
        task: what the task has saved.
    """

    state: np.ndarray
    model: dict[str, np.ndarray]
    rng: dict[str, Any]
    task: dict[str, Any]

    @classmethod
    def take(cls, simulation: Simulation) -> Snapshot:
        """The present moment."""
        world = simulation.world
        state = np.empty(mujoco.mj_stateSize(world.model, _STATE))
        mujoco.mj_getState(world.model, world.data, state, _STATE)
        rng = copy.deepcopy(dict(world.rng.bit_generator.state))
        return cls(state, world.varied(), rng, simulation.task.save())

    def restore(self, simulation: Simulation) -> None:
        """Bring the simulation back to the moment of the snapshot; what observes it is not told."""
        world = simulation.world
        world.vary(self.model)
        mujoco.mj_setState(world.model, world.data, self.state, _STATE)
        world.rng.bit_generator.state = copy.deepcopy(self.rng)
        simulation.task.restore(self.task)
        mujoco.mj_forward(world.model, world.data)
