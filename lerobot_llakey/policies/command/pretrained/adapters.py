"""Adapters (LoRA and others) of an image-text model: which layers get them by default, and merging trained ones.

LeRobot wraps a policy in adapters with ``--peft.method_type=LORA --peft.r=...``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from torch import nn

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.policies.command.model_settings import ADAPTER
from lerobot_llakey.policies.command.pretrained.loading import part_of
from lerobot_llakey.saved.folder import read_json
from lerobot_llakey.saved.weights import check_weights

ADAPTER_WEIGHTS = "adapter_model.safetensors"


def adapter_targets(model: nn.Module, trained: Sequence[str], stop_id: int, method: str = "LORA") -> dict[str, Any]:
    """Settings of ``peft`` for the parts that would be trained without adapters.

    Args:
        model: an image-text model, named ``model`` within the policy.
        trained: the trained parts, out of ``PARTS``: all linear layers of the language model and the vision tower get
            adapters; the small projector is trained as a whole.
        stop_id: the stop token; its new row in the output layer is trained too.
        method: peft's name of the method; only LoRA can train single rows, others train the whole output layer.

    Raises:
        LlakeyError: if no trained part gets adapters.
    """
    layers: dict[str, set[str]] = {}
    projectors: set[str] = set()
    for name, module in model.named_modules():
        part = part_of(name)
        if part in trained and part != "projector" and isinstance(module, nn.Linear) and name != "lm_head":
            layers.setdefault(_stem(name), set()).add(name.rsplit(".", 1)[-1])
        if part == "projector" and part_of(name.rpartition(".")[0]) != "projector" and name:
            projectors.add(name.rsplit(".", 1)[-1])
    patterns = [rf"{re.escape(stem)}\..*\b({'|'.join(sorted(names))})" for stem, names in sorted(layers.items())]
    if not patterns:
        raise LlakeyError(
            f"Expected the language model or the vision tower to get adapters, got train={list(trained)}; add "
            "language to `train`, or train the projector without --peft."
        )
    whole = sorted(projectors) if "projector" in trained else []
    targets: dict[str, Any] = {"target_modules": rf"(.*\.)?model\.({'|'.join(patterns)})"}
    if method.upper() == "LORA":
        targets["trainable_token_indices"] = {"lm_head": [stop_id]}
    else:
        whole = [*whole, "lm_head"]
    return targets | {"modules_to_save": whole}


def _stem(name: str) -> str:
    """The first two modules of a name: "model.language_model.layers.0.mlp" -> "model.language_model"."""
    return ".".join(name.split(".")[:2])


def adapter_base(folder: Path) -> str:
    """Name or folder of the model that an adapter was trained on.

    Raises:
        LlakeyError: if the adapter does not name it.
    """
    base = read_json(folder / ADAPTER, "adapter's settings").get("base_model_name_or_path")
    if not base or not isinstance(base, str):
        raise LlakeyError(f"Expected {folder / ADAPTER} to name what the adapter was trained on, got no name; add it.")
    return base


def merge_adapter(policy: nn.Module, folder: Path) -> Any:
    """Merge an adapter into a policy's weights.

    Args:
        policy: the policy that the adapter was trained on.
        folder: of the adapter.
    """
    from peft import PeftModel

    check_weights(folder / ADAPTER_WEIGHTS)
    with reading(folder, "adapter"):
        return PeftModel.from_pretrained(policy, str(folder)).merge_and_unload()


class TakesAdapters:
    """The methods that LeRobot calls to wrap a policy in adapters (``PreTrainedPolicy.wrap_with_peft``)."""

    config: Any
    model: Any
    encoder: Any

    def _get_default_peft_targets(self) -> dict[str, Any]:
        targets = adapter_targets(self.model, self.config.trained_parts, self.encoder.stop_id)
        # The method, which decides how the output layer is trained, is known one call later.
        return {key: value for key, value in targets.items() if key == "target_modules"}

    def _preprocess_peft_cli_overrides(self, cli_overrides: dict[str, Any], peft_method_type: Any) -> dict[str, Any]:
        renamed: dict[str, Any] = super()._preprocess_peft_cli_overrides(cli_overrides, peft_method_type)  # type: ignore[misc]
        method = str(peft_method_type.value)
        defaults = adapter_targets(self.model, self.config.trained_parts, self.encoder.stop_id, method)
        given = {key: value for key, value in renamed.items() if value is not None}
        return defaults | given

    def _validate_peft_config(self, peft_config: Any) -> None:
        if self.config.model is None:
            super()._validate_peft_config(peft_config)  # type: ignore[misc]

    def _require_adapters(self) -> None:
        """Refuse to train 4-bit weights without adapters.

        Raises:
            LlakeyError: if the weights are quantised and the policy has no adapters.
        """
        if self.config.quantize and not self.config.use_peft:
            raise LlakeyError(
                f"Expected adapters to train with quantize={self.config.quantize}, got none; add "
                "--peft.method_type=LORA --peft.r=16, or set quantize=null."
            )
