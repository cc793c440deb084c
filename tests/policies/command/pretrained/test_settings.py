import pytest

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig


@pytest.mark.parametrize(
    ("settings", "parts"),
    [
        ({}, ("vision", "projector", "language")),
        ({"model": "a/b"}, ("projector", "language")),
        ({"model": "a/b", "freeze_vision": False}, ("vision", "projector", "language")),
        ({"freeze_vision": True}, ("projector", "language")),
        ({"model": "a/b", "train": ["projector"]}, ("projector",)),
    ],
)
def test_the_paper_freezes_the_vision_tower_of_a_pretrained_model(settings, parts):
    assert LlakeyCommandConfig(device="cpu", **settings).trained_parts == parts


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"train": []}, r"`train` to list some of .* got \[\]"),
        ({"train": ["eyes"]}, r"got \['eyes'\]"),
        ({"train": ["language"], "freeze_vision": True}, "one of `train` and `freeze_vision`"),
        ({"weights_dtype": "float16"}, "got 'float16'"),
        ({"weights_dtype": "bfloat16", "dtype": "float32"}, "set dtype=bfloat16"),
        ({"quantize": "8bit", "model": "a/b"}, "got '8bit'"),
        ({"quantize": "4bit"}, "pretrained `model` with quantize=4bit"),
        ({"prompt_format": "USER: {request}"}, r"slots \{system\} and \{request\}"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(ValueError, match=message):
        LlakeyCommandConfig(device="cpu", **settings)
