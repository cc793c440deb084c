"""Taking back what was tried: everything of a world that acting changes."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

if TYPE_CHECKING:
    from lerobot_llakey.sim.world import World

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_CHANGED = ("geom_rgba", "eq_data")
"""Parts of the model that tasks change while time goes by."""


@dataclass(frozen=True)
class Snapshot:
    """A moment of a world, to which it can go back exactly.

    Attributes:
        state: MuJoCo's integration state.
        model: the model's arrays that change.
        rng: state of the world's generator.
        task: the task's attributes.
    """

    state: np.ndarray
    model: dict[str, np.ndarray]
    rng: dict[str, Any]
    task: dict[str, Any]

    @classmethod
    def take(cls, world: World) -> Snapshot:
        """The present moment of a world."""
        state = np.empty(mujoco.mj_stateSize(world.model, _STATE))
        mujoco.mj_getState(world.model, world.data, state, _STATE)
        return cls(
            state=state,
            model={name: getattr(world.model, name).copy() for name in _CHANGED},
            rng=copy.deepcopy(dict(world.rng.bit_generator.state)),
            task=dict(vars(world.task)),
        )

    def restore(self, world: World) -> None:
        """Bring the world back to the moment of the snapshot; what observes it is not told."""
        for name, value in self.model.items():
            getattr(world.model, name)[:] = value
        mujoco.mj_setState(world.model, world.data, self.state, _STATE)
        world.rng.bit_generator.state = copy.deepcopy(self.rng)
        vars(world.task).update(self.task)
        mujoco.mj_forward(world.model, world.data)
