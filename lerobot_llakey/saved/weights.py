"""Weights are held against the policy that takes them before they are taken."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import torch
from lerobot.utils.device_utils import resolve_safetensors_device
from safetensors import safe_open
from safetensors.torch import load_model
from torch import Tensor

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.saved.folder import require_file, require_weights


class CheckedWeights:
    """The part of a policy that loads its weights, and refuses any that no training run would have left."""

    @classmethod
    def _load_as_safetensor(cls, model: Any, model_file: str, map_location: str, strict: bool) -> Any:
        file = Path(model_file)
        check_weights(require_weights(file.parent), model.state_dict())
        missing, unexpected = load_model(model, file, strict=False, device=resolve_safetensors_device(map_location))
        check_keys(file, missing, [name for name in unexpected if not name.startswith(model.weights_left_out)])
        return model

    @property
    def weights_left_out(self) -> tuple[str, ...]:
        """Beginnings of the names of weights that a checkpoint may hold and the policy does not take."""
        return ()


def check_keys(file: Path, missing: Iterable[str], unexpected: Iterable[str]) -> None:
    """Refuse weights that are not those of the policy.

    Raises:
        LlakeyError: if any are missing or unexpected.
    """
    missing, unexpected = sorted(missing), sorted(unexpected)
    if missing or unexpected:
        raise LlakeyError(
            f"Expected the weights that the settings say in {file}, got a checkpoint of another kind: {len(missing)} "
            f"missing {missing[:2]}, {len(unexpected)} unexpected {unexpected[:2]}; give one saved by this policy."
        )


def check_weights(file: Path, fresh: Mapping[str, Tensor] | None = None) -> None:
    """Refuse weights that are not finite, all zero, or not of the policy's kinds and shapes.

    Args:
        file: a safetensors file.
        fresh: the policy's tensors as it was made, by name; None holds the file's against nothing.

    Raises:
        LlakeyError: naming the file and the first tensor that is wrong.
    """
    require_file(file)
    with reading(file, "safetensors file"), safe_open(file, framework="pt") as weights:
        for name in weights.keys():  # noqa: SIM118 - not a mapping
            with torch.no_grad():
                wrong = _wrong(name, weights.get_tensor(name), None if fresh is None else fresh.get(name))
            if wrong:
                raise LlakeyError(
                    f"Expected weights that a policy can use in {file}, got {wrong}; fetch or make it anew."
                )


def _wrong(name: str, value: Tensor, fresh: Tensor | None) -> str:
    """What is wrong with a tensor; empty where nothing is."""
    if fresh is not None and value.shape != fresh.shape:
        shapes = f"{tuple(value.shape)} where the settings say {tuple(fresh.shape)}"
        return f"a checkpoint of another kind: {name} of shape {shapes}"
    floating = value.is_floating_point()
    if fresh is not None and floating != fresh.is_floating_point():
        return f"{name} of {_kind(value)} where the policy has {_kind(fresh)}"
    if not floating:
        return ""
    if not torch.isfinite(value).all():
        return f"NaN or infinity in {name}"
    # A bias may have stayed at its start, zero; a matrix or a gain that started otherwise does not end so.
    a_weight = value.ndim >= 2 or (name.endswith("weight") and value.numel() > 1)
    if a_weight and fresh is not None and not value.any() and fresh.any():
        return f"nothing but zeros in {name}"
    return ""


def _kind(value: Tensor) -> str:
    return str(value.dtype).removeprefix("torch.")
