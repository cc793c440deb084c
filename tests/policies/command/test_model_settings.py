import draccus
import pytest
from lerobot.configs import PreTrainedConfig

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
        ({"weights_dtype": "bfloat16", "dtype": "float32"}, "set dtype=auto"),
        ({"quantize": "8bit", "model": "a/b"}, "got '8bit'"),
        ({"quantize": "4bit"}, "pretrained `model` with quantize=4bit"),
        ({"prompt_format": "USER: {request}"}, r"slots \{system\} and \{request\}"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(ValueError, match=message):
        LlakeyCommandConfig(device="cpu", **settings)


def test_settings_are_read_from_a_command_line_and_survive_saving(tmp_path):
    arguments = ["--processor_settings={do_image_splitting: false, max_pixels: 200704}", "--train=[vision,projector]"]
    config = draccus.parse(LlakeyCommandConfig, args=["--device=cpu", "--model=a/b", *arguments])
    assert config.processor_settings == {"do_image_splitting": False, "max_pixels": 200704}
    assert config.trained_parts == ("vision", "projector")
    config.save_pretrained(tmp_path)
    assert PreTrainedConfig.from_pretrained(tmp_path) == config


def test_checkpoints_of_before_these_settings_load():
    old = {
        "device": "cpu",
        "model": "a/b",
        "freeze_vision": None,
        "prompt_format": "{system} USER: {request} ASSISTANT:",
    }
    config = draccus.decode(LlakeyCommandConfig, old)
    assert config.trained_parts == ("projector", "language") and config.weights_dtype == "float32"
