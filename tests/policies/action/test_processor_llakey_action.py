import torch
from lerobot.policies.factory import make_pre_post_processors

from fakes_action import observation, small_config
from lerobot_llakey import schema


def test_observations_and_tasks_pass_unchanged():
    config = small_config()
    config.narrow_features()
    pre, post = make_pre_post_processors(config, dataset_stats=None)
    batch, _, _ = observation(rows=2)
    out = pre(dict(batch))
    for key in (schema.STATE, schema.intrinsics_key("front"), schema.depth_key("front"), schema.image_key("wrist")):
        assert torch.equal(out[key], batch[key])
    assert schema.INSTRUCTION not in out  # looked up by index in training, see training_texts
    assert out[schema.TASK] == batch[schema.TASK]
    assert torch.equal(post(batch[schema.ACTION]), batch[schema.ACTION])
