from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.pretrained.freezing import freeze_vision
from lerobot_llakey.policies.command.small.build import build_small
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer


def test_vision_tower_is_frozen_and_the_rest_is_not():
    model = build_small(LlakeyCommandConfig(device="cpu", vision_layers=1, text_layers=1), WordTokenizer(["a"]))
    freeze_vision(model)
    frozen = {name for name, value in model.named_parameters() if not value.requires_grad}
    assert frozen == {name for name, _ in model.named_parameters() if "vision_tower" in name}
    assert frozen
