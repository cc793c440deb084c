from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file, save_file
from torch import Tensor

from fakes_action import small_config
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.saved.weights import check_keys, check_weights


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("action")
    LlakeyActionPolicy(small_config()).save_pretrained(folder)
    return folder


def _with(value: float) -> Callable[[Tensor], Tensor]:
    def change(weights: Tensor) -> Tensor:
        weights.view(-1)[0] = value
        return weights

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_with(float("nan")), "got NaN or infinity in {}"),
        (_with(float("inf")), "got NaN or infinity in {}"),
        (torch.zeros_like, "got nothing but zeros in {}"),
        (lambda weights: weights[:-1].contiguous(), "kind: {} of shape"),
        (lambda weights: weights.to(torch.int8), "got {} of int8 where the policy has float32"),
        (lambda weights: weights > 0, "got {} of bool where the policy has float32"),
        (None, "1 missing"),
    ],
)
def test_weights_that_no_training_leaves_are_refused_by_name(
    saved: Path, tmp_path: Path, change: Callable[[Tensor], Tensor] | None, words: str
) -> None:
    weights = load_file(saved / "model.safetensors")
    name = next(name for name, value in weights.items() if value.ndim == 2 and value.any())
    if change is None:
        del weights[name]
    else:
        weights[name] = change(weights[name].clone())
    for file in saved.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    save_file(weights, tmp_path / "model.safetensors")
    with pytest.raises(LlakeyError) as caught:
        LlakeyActionPolicy.from_pretrained(tmp_path)
    assert words.format(name) in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_a_fresh_policy_and_one_in_half_precision_load(saved: Path, tmp_path: Path) -> None:
    LlakeyActionPolicy.from_pretrained(saved)
    weights = load_file(saved / "model.safetensors")
    weights = {name: value.half() if value.is_floating_point() else value for name, value in weights.items()}
    save_file(weights, tmp_path / "model.safetensors")
    check_weights(tmp_path / "model.safetensors", LlakeyActionPolicy(small_config()).state_dict())


def test_keys_must_fit(tmp_path: Path) -> None:
    check_keys(tmp_path, [], [])
    with pytest.raises(ValueError, match="1 missing"):
        check_keys(tmp_path, ["action.head"], [])
