"""Saves and loads command policies: whole checkpoints, adapters, and chat models, which have no weights."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from lerobot.configs import PreTrainedConfig
from torch import Tensor

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.model_settings import ADAPTER, ASSETS
from lerobot_llakey.policies.command.pretrained.adapters import adapter_base, merge_adapter
from lerobot_llakey.policies.command.pretrained.loading import save_assets
from lerobot_llakey.saved.folder import DOWNLOAD, inspect_checkpoint
from lerobot_llakey.saved.processors import OUR_STEPS

log = logging.getLogger(__name__)


class CommandCheckpoints:
    """The methods of the command policy that load and save it."""

    config: Any
    model: Any
    chat: Any
    _processor: Any

    @classmethod
    def from_pretrained(cls, pretrained_name_or_path: str | Path, **kwargs: Any) -> Any:
        """Load a saved policy; see ``PreTrainedPolicy.from_pretrained``.

        Adapters, which LeRobot's ``make_policy`` keeps separate, are merged into the weights that they were trained on.

        Raises:
            MissingFileError: if there is no checkpoint.
            LlakeyError: if it is broken or names something forbidden, or an adapter does not name its base model.
        """
        policy_class: Any = cls
        adapters: tuple[Path, ...] = kwargs.pop("adapters", ())
        given = kwargs.get("config")
        if given is not None and given.use_peft and str(pretrained_name_or_path) == given.model:
            # An adapter's base may be a pretrained model instead of a policy.
            return policy_class(given, dataset_meta=kwargs.get("dataset_meta")).to(given.device).eval()
        options = {name: kwargs[name] for name in DOWNLOAD if kwargs.get(name) is not None}
        folder = inspect_checkpoint(pretrained_name_or_path, OUR_STEPS, **options)
        config = given or PreTrainedConfig.from_pretrained(folder)
        if getattr(config, "backend", None) == "chat":
            return policy_class(config).eval()  # nothing to load: there are no weights
        if (folder / ADAPTER).is_file():
            source = adapter_base(folder)
            log.info("The adapter %s goes onto the weights of %s.", folder, source)
            if folder.resolve() in adapters:
                raise LlakeyError(
                    f"Expected adapters that come down to a checkpoint, got {folder}, which goes back to itself; "
                    f"correct base_model_name_or_path in its {ADAPTER}."
                )
            on = {"config": config, "revision": None, "adapters": (*adapters, folder.resolve())}
            base = cls.from_pretrained(source, **kwargs | on)
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
