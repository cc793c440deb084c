"""The environment's settings, checked before any work is lost."""

import multiprocessing

import pytest
from lerobot.envs.configs import EnvConfig
from lerobot.envs.utils import env_to_policy_features

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig


def test_it_is_registered() -> None:
    assert EnvConfig.get_choice_class("llakey_sim") is LlakeySimConfig


def test_features_become_the_contract() -> None:
    features = env_to_policy_features(LlakeySimConfig(image_size=96))
    assert features[schema.image_key("front")].shape == (3, 96, 96)
    assert features[schema.depth_key("wrist")].shape == (1, 96, 96)
    assert features[schema.STATE].shape == (schema.STATE_DIM,)


def test_each_task_is_a_suite() -> None:
    envs = LlakeySimConfig(task="open_drawer").create_envs(1)
    assert list(envs) == ["open_drawer"] and list(envs["open_drawer"]) == [0]


def test_bad_settings_are_told() -> None:
    with pytest.raises(ValueError, match="max_parallel_tasks=1"):
        LlakeySimConfig(max_parallel_tasks=2)
    with pytest.raises(ValueError, match="Expected a split"):
        LlakeySimConfig(split="holdout")
    with pytest.raises(ValueError, match=r"Expected env\.image_size"):
        LlakeySimConfig(image_size=4)
    with pytest.raises(ValueError, match="Expected tasks"):
        LlakeySimConfig(task="fold_laundry")
    with pytest.raises(ValueError, match=r"eval\.batch_size"):
        LlakeySimConfig(task="open_drawer").create_envs(0)


@pytest.mark.parametrize("parallel", [2, 0, -1])
def test_tasks_are_not_run_in_parallel(parallel: int) -> None:
    with pytest.raises(LlakeyError, match="max_parallel_tasks=1"):
        LlakeySimConfig(max_parallel_tasks=parallel)


def test_lerobots_workers_import_together(monkeypatch: pytest.MonkeyPatch) -> None:
    shared: list[str] = []
    monkeypatch.setattr(multiprocessing, "set_forkserver_preload", shared.extend)
    LlakeySimConfig(task="open_drawer").create_envs(2, use_async_envs=False)
    assert not shared
    LlakeySimConfig(task="open_drawer").create_envs(2, use_async_envs=True)
    assert {"lerobot_llakey.sim.env", "lerobot.envs.utils"} <= set(shared)
