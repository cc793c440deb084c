import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.processor_llakey_command import make_llakey_command_pre_post_processors


def test_images_and_texts_pass_unchanged(small_config, keysteps, batch):
    small_config.use_default_features()
    preprocessor, _ = make_llakey_command_pre_post_processors(small_config, keysteps.meta.stats)
    result = preprocessor(dict(batch))
    for key in small_config.image_keys:
        assert torch.equal(result[key], batch[key])
    assert list(result[schema.TASK]) == list(batch[schema.TASK])
    assert not set(schema.TEXTS) & set(result)  # looked up by index in training, see training_texts
