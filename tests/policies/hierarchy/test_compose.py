from pathlib import Path

import torch
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import make_policy, make_pre_post_processors

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.compose import compose
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy


def test_two_parts_become_one_checkpoint_that_lerobot_loads(make_tiny, keysteps, observation, tmp_path: Path) -> None:
    trained = make_tiny()
    trained.command.save_pretrained(tmp_path / "command")
    trained.action.save_pretrained(tmp_path / "action")
    composed = compose(tmp_path / "command", tmp_path / "action", tmp_path / "both", device="cpu", repeat_threshold=7)
    config = PreTrainedConfig.from_pretrained(tmp_path / "both")
    config.pretrained_path = tmp_path / "both"
    loaded = make_policy(config, ds_meta=keysteps.meta)
    assert loaded.config.repeat_threshold == 7
    preprocessor, postprocessor = make_pre_post_processors(config, pretrained_path=str(tmp_path / "both"))
    actions = postprocessor(loaded.select_action(preprocessor(dict(observation))))
    assert torch.equal(actions, composed.select_action(observation))
    assert loaded.last_instructions == composed.last_instructions
    assert schema.INSTRUCTION not in config.input_features


def test_half_precision_halves_the_file_and_barely_changes_the_actions(make_tiny, observation, tmp_path: Path) -> None:
    trained = make_tiny()
    trained.command.save_pretrained(tmp_path / "command")
    trained.action.save_pretrained(tmp_path / "action")
    sizes, actions = [], []
    for half in (False, True):
        folder = tmp_path / f"half_{half}"
        compose(tmp_path / "command", tmp_path / "action", folder, half=half, device="cpu")
        sizes.append((folder / "model.safetensors").stat().st_size)
        loaded = LlakeyPolicy.from_pretrained(folder)
        assert {value.dtype for value in loaded.parameters()} == {torch.float32}
        actions.append(loaded.action.state_dict())
    assert sizes[1] < 0.6 * sizes[0]
    for name, value in actions[0].items():
        assert torch.allclose(value.float(), actions[1][name].float(), atol=1e-3), name
