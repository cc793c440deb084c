"""Settings of an environment are refused alike from Python and from LeRobot's command line."""

from typing import Any

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig
from lerobot_llakey.sim.env import LlakeySimEnv

_WRONG = [
    *(("image_size", value) for value in (0, -1, 15, 100_000, 64.0, "64", True, None)),
    *(("episode_length", value) for value in (0, -5, 2.5, float("nan"), None)),
    *(("render_size", value) for value in ((0, 0), (480,), (480, -1), (480, 1e9), "480x640", 480, None)),
    *(("split", value) for value in ("holdout", "", None)),
    *(("disturbance", value) for value in ("earthquake", None, 1)),
    *(("oracle_instructions", value) for value in ("false", 1, None)),
    *(("detailed", value) for value in ("no", 0)),
    *(("task", value) for value in ("fold_laundry", "", ",", None)),
    *(("fps", value) for value in (0, -1, 1.5, 10**9)),
]


@pytest.mark.parametrize(("name", "value"), _WRONG)
def test_wrong_settings_are_refused(name: str, value: Any) -> None:
    with pytest.raises(LlakeyError, match=r"Expected .*, got .*;"):
        LlakeySimConfig(**{name: value})
    argument = {"fps": "render_fps"}.get(name, name)
    with pytest.raises(LlakeyError, match=r"Expected .*, got .*;"):
        LlakeySimEnv(**{"task": "open_drawer", argument: value})


def test_the_sentence_names_the_setting_as_it_was_written() -> None:
    with pytest.raises(LlakeyError, match=r"env\.render_size .*got 0;"):
        LlakeySimConfig(render_size=(0, 0))
    with pytest.raises(LlakeyError, match="in render_size"):
        LlakeySimEnv("open_drawer", render_size=(0, 0))


def test_a_size_beyond_mujocos_default_is_drawn() -> None:
    env = LlakeySimEnv("open_drawer", image_size=16, render_size=(16, 1300))
    env.reset(seed=0)
    assert env.render().shape == (16, 1300, 3)
    env.close()
