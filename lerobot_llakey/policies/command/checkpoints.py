"""Saving a command policy and loading it again: whole checkpoints, adapters, chat models, which have no weights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from huggingface_hub import snapshot_download
from lerobot.configs import PreTrainedConfig
from torch import Tensor

from lerobot_llakey.policies.command.pretrained.adapters import ADAPTER, adapter_base, merge_adapter
from lerobot_llakey.policies.command.pretrained.loading import ASSETS, save_assets


class CommandCheckpoints:
    """The part of the command policy that loads and saves it."""

    config: Any
    model: Any
    chat: Any
    _processor: Any

    @classmethod
    def from_pretrained(cls, pretrained_name_or_path: str | Path, **kwargs: Any) -> Any:
        """Load a saved policy; see ``PreTrainedPolicy.from_pretrained``.

        Adapters, which LeRobot's ``make_policy`` keeps apart, are merged into the weights that they were trained on.

        Raises:
            ValueError: if an adapter does not say what it was trained on.
        """
        policy_class: Any = cls
        given = kwargs.get("config")
        if given is not None and given.use_peft and str(pretrained_name_or_path) == given.model:
            # What an adapter was trained on may be a pretrained model rather than a policy.
            return policy_class(given, dataset_meta=kwargs.get("dataset_meta")).to(given.device).eval()
        folder = Path(pretrained_name_or_path)
        if not folder.is_dir():
            patterns = ["*.json", "*.safetensors", f"{ASSETS}/*"]
            revision = kwargs.get("revision")
            folder = Path(snapshot_download(str(pretrained_name_or_path), revision=revision, allow_patterns=patterns))
        config = given or PreTrainedConfig.from_pretrained(folder)
        if getattr(config, "backend", None) == "chat":
            return policy_class(config).eval()  # nothing to load: there are no weights
        if (folder / ADAPTER).is_file():
            base = cls.from_pretrained(adapter_base(folder), **kwargs | {"config": config, "revision": None})
            policy = merge_adapter(base, folder)
            policy.config.use_peft = False
            return policy.eval()
        if (folder / ASSETS).is_dir():
            kwargs["assets_dir"] = folder / ASSETS
        return super().from_pretrained(folder, **kwargs)  # type: ignore[misc]

    def _save_pretrained(self, save_directory: Path, state_dict: dict[str, Tensor] | None = None) -> None:
        if self.chat is not None:
            self.config._save_pretrained(Path(save_directory))
            return
        super()._save_pretrained(save_directory, state_dict=state_dict)  # type: ignore[misc]
        if self._processor is not None:
            save_assets(Path(save_directory) / ASSETS, self.model, self._processor)
