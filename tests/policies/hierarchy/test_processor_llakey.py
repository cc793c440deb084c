import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.processor_llakey import make_llakey_pre_post_processors


def test_observations_texts_and_actions_pass_unchanged(make_tiny, keysteps, training_batch) -> None:
    config = make_tiny().config
    preprocessor, postprocessor = make_llakey_pre_post_processors(config, keysteps.meta.stats)
    result = preprocessor(dict(training_batch))
    for key in (
        schema.STATE,
        schema.ACTION,
        schema.intrinsics_key("front"),
        schema.extrinsics_key("wrist"),
        schema.depth_key("wrist"),
    ):
        assert torch.equal(result[key], training_batch[key])
    assert list(result[schema.TASK]) == list(training_batch[schema.TASK])
    assert torch.equal(result[schema.INDEX], training_batch[schema.INDEX]), "by which the texts are found"
    action = torch.rand(3, schema.ACTION_DIM)
    assert torch.equal(postprocessor(action), action)


def test_the_oracles_texts_pass_unchanged(make_tiny, observation) -> None:
    preprocessor, _ = make_llakey_pre_post_processors(make_tiny().config)
    result = preprocessor(observation | {schema.ORACLE_INSTRUCTION: ["grasp the lid"] * 3})
    assert result[schema.ORACLE_INSTRUCTION] == ["grasp the lid"] * 3
