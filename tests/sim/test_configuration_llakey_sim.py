"""The environment's settings, checked before any work is lost."""

import multiprocessing

import pytest
import torch
from lerobot.envs.configs import EnvConfig
from lerobot.envs.utils import NEW_ROLLOUT_OPTION, env_to_policy_features, preprocess_observation

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig


def test_it_is_registered() -> None:
    assert EnvConfig.get_choice_class("llakey_sim") is LlakeySimConfig


def test_features_become_the_contract() -> None:
    features = env_to_policy_features(LlakeySimConfig(image_size=96))
    assert features[schema.image_key("front")].shape == (3, 96, 96)
    assert features[schema.depth_key("wrist")].shape == (1, 96, 96)
    assert features[schema.STATE].shape == (len(schema.SIM_STATE_NAMES),)
    assert features[schema.intrinsics_key("front")].shape == (4,)
    assert features[schema.extrinsics_key("wrist")].shape == (7,)
    action = {schema.ACTION}
    observed = {key for key in schema.dataset_features() if key.startswith("observation.")}
    assert set(features) == observed | action


def test_the_oracles_instructions_reach_policies_as_texts() -> None:
    config = LlakeySimConfig(task="open_drawer", image_size=32, oracle_instructions=True)
    vector = config.create_envs(2)["open_drawer"][0]
    observation, _ = vector.reset(seed=[0, 1], options={NEW_ROLLOUT_OPTION: True})
    said = list(vector.call("oracle_instruction"))
    vector.close()
    preprocessor, postprocessor = config.get_env_processors()
    batch = preprocessor(preprocess_observation(observation) | {"task": ["open"] * 2})
    assert batch[schema.ORACLE_INSTRUCTION] == said and all(said)
    assert batch["task"] == ["open"] * 2 and batch[schema.STATE].shape == (2, 15)
    action = torch.zeros(2, schema.ACTION_DIM)
    assert postprocessor({schema.ACTION: action})[schema.ACTION] is action


def test_without_an_oracle_there_is_no_text() -> None:
    batch = LlakeySimConfig().get_env_processors()[0]({schema.STATE: torch.zeros(1, 15)})
    assert schema.ORACLE_INSTRUCTION not in batch and batch[schema.STATE].shape == (1, 15)


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
