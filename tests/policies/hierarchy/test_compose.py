import json
from pathlib import Path

import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.policies.factory import make_policy, make_pre_post_processors
from safetensors.torch import load_file

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.compose import compose, split
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


def test_the_checkpoint_does_not_say_in_which_folders_its_parts_lay(make_tiny, tmp_path: Path) -> None:
    trained = make_tiny()
    for name, part in (("command", trained.command), ("action", trained.action)):
        part.config.pretrained_path = tmp_path / "somewhere"
        part.save_pretrained(tmp_path / name)
    assert "somewhere" in (tmp_path / "action" / "config.json").read_text()
    compose(tmp_path / "command", tmp_path / "action", tmp_path / "both", device="cpu")
    settings = _settings(tmp_path / "both")
    assert settings["command"]["pretrained_path"] is None and settings["action"]["pretrained_path"] is None


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


def _weights(folder: Path) -> dict[str, torch.Tensor]:
    return load_file(folder / "model.safetensors")


def _same(first: Path, second: Path) -> bool:
    weights, others = _weights(first), _weights(second)
    return weights.keys() == others.keys() and all(torch.equal(weights[key], others[key]) for key in weights)


def _settings(folder: Path) -> dict:
    return json.loads((folder / "config.json").read_text())


def test_parts_come_back_from_a_composition_to_the_last_bit(make_tiny, observation, tmp_path: Path) -> None:
    trained = make_tiny()
    for name in ("command", "action"):
        getattr(trained, name).save_pretrained(tmp_path / name)
    compose(tmp_path / "command", tmp_path / "action", tmp_path / "both", device="cpu")
    folders = split(tmp_path / "both", tmp_path / "parts")
    assert folders == (tmp_path / "parts/command", tmp_path / "parts/action")
    for folder in folders:
        assert _same(folder, tmp_path / folder.name)
        assert _settings(folder) == _settings(tmp_path / folder.name)
        config = PreTrainedConfig.from_pretrained(folder)
        preprocessor, _ = make_pre_post_processors(config, pretrained_path=str(folder))
        assert torch.equal(preprocessor(dict(observation))[schema.STATE], observation[schema.STATE])


@pytest.mark.parametrize("half", [False, True])
def test_a_composition_comes_back_from_its_parts_to_the_last_bit(half: bool, make_tiny, tmp_path: Path) -> None:
    trained = make_tiny()
    for name in ("command", "action"):
        getattr(trained, name).save_pretrained(tmp_path / name)
    compose(tmp_path / "command", tmp_path / "action", tmp_path / "both", half=half, device="cpu")
    folders = split(tmp_path / "both", tmp_path / "parts", half=half)
    compose(*folders, tmp_path / "again", half=half, device="cpu")
    assert _same(tmp_path / "both", tmp_path / "again")
    assert _settings(tmp_path / "both") == _settings(tmp_path / "again")


def test_what_cannot_be_split_is_refused(make_tiny, tmp_path: Path) -> None:
    make_tiny(commander="task").save_pretrained(tmp_path / "alone")
    with pytest.raises(ValueError, match=r"a checkpoint with a command policy at .* commander is 'task'"):
        split(tmp_path / "alone", tmp_path / "parts")
    with pytest.raises(FileNotFoundError, match="Expected a checkpoint folder"):
        split(tmp_path / "nowhere", tmp_path / "parts")
