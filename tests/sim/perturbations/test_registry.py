"""Disturbances by name."""

import numpy as np
import pytest

from lerobot_llakey.sim.perturbations.events import EVENTS, Event
from lerobot_llakey.sim.perturbations.execution_noise import Imprecision
from lerobot_llakey.sim.perturbations.registry import DISTURBANCES, make_disturbance


def test_every_name_makes_a_disturbance_that_has_not_struck() -> None:
    made = {kind: make_disturbance(kind, np.random.default_rng(0)) for kind in DISTURBANCES}
    assert all(isinstance(made[kind], Event) for kind in EVENTS)
    assert isinstance(made["imprecise"], Imprecision)
    assert not any(one.struck or one.time is not None for one in made.values())


def test_an_unknown_disturbance_is_refused() -> None:
    with pytest.raises(ValueError, match="got 'earthquake'; pick one"):
        make_disturbance("earthquake", np.random.default_rng(0))
