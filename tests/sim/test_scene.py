"""The look of a scene varies with its seed and nothing else."""

import numpy as np

from lerobot_llakey.sim.scene import vary_look
from lerobot_llakey.sim.simulation import Simulation


def test_look_follows_the_generator(simulation: Simulation) -> None:
    model = simulation.world.model
    looks = []
    for seed in (1, 1, 2):
        vary_look(model, np.random.default_rng(seed))
        looks.append((model.geom("table").rgba.copy(), model.light("lamp").pos.copy()))
    assert np.array_equal(looks[0][0], looks[1][0]) and np.array_equal(looks[0][1], looks[1][1])
    assert not np.array_equal(looks[0][0], looks[2][0])
