"""Time goes by in steps, and who watches is called at its rate."""

import numpy as np

from lerobot_llakey.sim.simulation import Simulation


def test_observer_is_called_at_its_rate(simulation: Simulation) -> None:
    simulation.reset(0)
    frames: list[float] = []
    simulation.clock.observe(lambda: frames.append(simulation.world.data.time), 10)
    simulation.clock.advance(1.0)
    with simulation.clock.unobserved():
        simulation.clock.advance(1.0)
    simulation.clock.observe(None)
    assert len(frames) == 10 and np.allclose(np.diff(frames), 0.1)


def test_what_goes_wrong_is_told_once(simulation: Simulation) -> None:
    simulation.reset(0)
    assert simulation.clock.warnings() == []
    simulation.world.data.qvel[0] = np.nan
    simulation.clock.step()
    assert simulation.clock.warnings() != []
    assert simulation.clock.warnings() == []
