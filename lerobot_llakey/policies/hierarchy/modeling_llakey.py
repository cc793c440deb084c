"""The hierarchical policy: the command policy says the next basic action, the action policy does it, and so on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from lerobot.configs import FeatureType, PolicyFeature, PreTrainedConfig
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.command.model_settings import ASSETS
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.pretrained.loading import save_assets
from lerobot_llakey.policies.hierarchy.commanders import build_commander
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.decision import Decision
from lerobot_llakey.policies.hierarchy.loop import Loop
from lerobot_llakey.policies.hierarchy.model_card import PublishedPolicy
from lerobot_llakey.policies.hierarchy.parts import check_training_dataset, load_part, parameter_groups
from lerobot_llakey.policies.hierarchy.step_log import Step
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor
from lerobot_llakey.policies.training_texts import training_texts
from lerobot_llakey.saved.folder import DOWNLOAD, inspect_checkpoint, read_settings
from lerobot_llakey.saved.processors import OUR_STEPS
from lerobot_llakey.saved.weights import CheckedWeights


class LlakeyPolicy(CheckedWeights, PublishedPolicy):
    """LLaKey: two policies in a loop, with its memory kept per row of the batch (algorithm 1 of the paper).

    A checkpoint is one ``config.json`` with the settings and one ``model.safetensors`` with the weights of both parts.

    Args:
        config: the settings; parts come from ``command_path`` and ``action_path`` where given, else they are fresh.
        dataset_stats, dataset_meta: of the training dataset, handed to fresh parts.
        assets_dir: folder of a pretrained language model's architecture, set by :meth:`from_pretrained`.

    Attributes:
        loop: what is remembered of the episodes; its ``corrections`` take a person's words, and its ``commander``, who
            gives the instructions, may be replaced.
    """

    config_class = LlakeyConfig
    name = "llakey"
    config: LlakeyConfig

    def __init__(
        self,
        config: LlakeyConfig,
        dataset_stats: Mapping[str, Any] | None = None,
        dataset_meta: Any | None = None,
        assets_dir: Path | None = None,
        **_: Any,
    ) -> None:
        super().__init__(config)
        context: dict[str, Any] = {"dataset_stats": dataset_stats, "dataset_meta": dataset_meta}
        for part in (config.command, config.action):
            part.device = config.device
            part.input_features = part.input_features or dict(config.input_features or {})
            part.output_features = part.output_features or dict(config.output_features or {})
        self._texts = training_texts(dataset_meta)
        if dataset_meta is not None:
            config.learn_grammar(dataset_meta.features)
        config.share_grammar()
        self.command: LlakeyCommandPolicy | None = None
        if config.has_command and config.command_path is None:
            self.command = LlakeyCommandPolicy(config.command, **context, assets_dir=assets_dir)
        self.action: LlakeyActionPolicy
        if config.action_path is None:
            self.action = LlakeyActionPolicy(config.action, **context)
        self._load_parts(dataset_meta)
        check_training_dataset(config, dataset_meta)  # parts that were loaded may read other columns
        self.reset()

    def _load_parts(self, dataset_meta: Any | None = None) -> None:
        """Put the parts that the settings name by path in place, and freeze what is not trained.

        Raises:
            LlakeyError: if the parts were trained on robots of other states.
        """
        config = self.config
        if config.has_command and config.command_path is not None:
            self.command = load_part(LlakeyCommandPolicy, config.command_path, config.device, config.command)
            config.command = self.command.config
        if config.action_path is not None:
            self.action = load_part(LlakeyActionPolicy, config.action_path, config.device, config.action)
            config.action = self.action.config
        config.command_path = config.action_path = None
        config.share_grammar()
        parts: list[PreTrainedConfig] = [config.action, config.command] if config.has_command else [config.action]
        if dataset_meta is not None:  # parts that were loaded may come from another robot
            for part in (config.action, config.command):
                part.learn_robot(dataset_meta)
        names = config.action.state_names
        if names != (config.command.state_names or names):
            raise LlakeyError(
                f"Expected parts trained on one robot's state, got {', '.join(config.command.state_names)} for the "
                f"command part and {', '.join(names) or 'none'} for the action part; give parts of one dataset."
            )
        config.command.state_names = list(names)
        config.input_features = {schema.STATE: PolicyFeature(FeatureType.STATE, (len(config.action.state_names),))}
        for part in parts:
            config.input_features |= part.input_features or {}
        config.output_features = dict(config.action.output_features or {})
        if self.command is not None and not config.train_command:
            self.command.requires_grad_(False)
        if not config.train_action:
            self.action.requires_grad_(False)
        self.loop = Loop(config, build_commander(config, self.command))

    @classmethod
    def from_pretrained(
        cls, pretrained_name_or_path: str | Path, *, config: PreTrainedConfig | None = None, **kwargs: Any
    ) -> LlakeyPolicy:
        """Load a saved checkpoint that holds both parts, from a folder or the Hub.

        A ``command_path`` or ``action_path`` in ``config`` then replaces that part.

        Raises:
            MissingFileError: if there is no checkpoint.
            LlakeyError: if it is a checkpoint of another kind, broken, or names what no checkpoint may.
        """
        options = {name: kwargs[name] for name in DOWNLOAD if name in kwargs}
        folder = inspect_checkpoint(pretrained_name_or_path, OUR_STEPS, **options)
        saved_type = read_settings(folder)["type"]
        # The given settings may be of the right type while the weights are not: both count.
        kinds = {saved_type, cls.name if config is None else config.type} - {cls.name}
        if not kinds:
            config = config or PreTrainedConfig.from_pretrained(folder)
        if kinds or not isinstance(config, LlakeyConfig):
            raise LlakeyError(
                f"Expected a checkpoint of type 'llakey' at {pretrained_name_or_path}, got one of type "
                f"{min(kinds)!r}: a checkpoint of another kind; a part goes in command_path or action_path."
            )
        paths = config.command_path, config.action_path
        config.command_path = config.action_path = None
        if (folder / ASSETS).is_dir():
            kwargs["assets_dir"] = folder / ASSETS
        policy = super().from_pretrained(folder, config=config, **kwargs)
        config.command_path, config.action_path = paths
        policy._load_parts(kwargs.get("dataset_meta"))
        if paths == (None, None):
            policy.evaluated_in = folder
        return policy.to(config.device).eval()

    @property
    def weights_left_out(self) -> tuple[str, ...]:
        """Those of a command policy, where another commander or a chat model takes its place."""
        built = self.command is not None and self.command.chat is None
        return () if built else ("command.",)

    def get_optim_params(self) -> list[dict[str, Any]]:
        """Parameter groups of the parts that are trained."""
        groups = []
        if self.command is not None and self.config.train_command:
            groups += parameter_groups(self.command, self.config.command_lr_multiplier)
        if self.config.train_action:
            groups += parameter_groups(self.action, self.config.action_lr_multiplier)
        return groups

    def forward(self, batch: dict[str, Any], reduction: str = "mean") -> tuple[Tensor, dict[str, Any]]:
        """Sum of the losses of the parts that are trained.

        Args:
            batch: what both parts need; see their ``forward``.
            reduction: "mean", or "none" for one loss a sample (B,).

        Returns:
            The loss, and both parts' metrics under ``command_...`` and ``action_...``.
        """
        if self.training:
            self.evaluated_in = None  # results of other weights do not count
        batch = self._texts.fill(batch)
        losses: list[Tensor] = []
        metrics: dict[str, Any] = {}
        options = {} if reduction == "mean" else {"reduction": reduction}
        for name, part in (("command", self.command), ("action", self.action)):
            if part is None or not getattr(self.config, f"train_{name}"):
                continue
            loss, details = part.forward(batch, **options)
            losses.append(loss)
            metrics[f"{name}_loss"] = float(loss.detach().mean())
            metrics |= {f"{name}_{key.removeprefix(f'{name}_')}": value for key, value in (details or {}).items()}
        return torch.stack(losses).sum(0), metrics

    @property
    def supervisors(self) -> list[Supervisor]:
        """One for each row since the last :meth:`reset`."""
        return self.loop.supervisors

    @property
    def log(self) -> list[list[Step]]:
        """What was done in each row since the last :meth:`reset`, step by step."""
        return self.loop.log.steps

    @property
    def last_instructions(self) -> list[str]:
        """The instruction last carried out in each row, for overlays."""
        return [row.last.instruction for row in self.supervisors if row.last is not None]

    def reset(self) -> None:
        """Forget all episodes; the next batch sets the number of rows."""
        self.loop.reset()
        self.action.reset()

    def reseed(self, seed: int) -> None:
        """Take another seed for random moves, from the next reset on."""
        self.config.seed = seed

    @torch.no_grad()
    def decide(self, batch: dict[str, Any], known: Decision | None = None) -> Decision:
        """What each row would do now; nothing is remembered, see :meth:`Loop.decide`."""
        return self.loop.decide(batch, known)

    @torch.no_grad()
    def act(self, decision: Decision) -> Tensor:
        """Carry a decision out: the actions (B, 9) to send, see :meth:`select_action`."""
        actions = self.action.select_action(decision.batch)
        steps = self.loop.commit(decision, actions.float().cpu().numpy())
        return torch.tensor([step.sent for step in steps], dtype=torch.float32, device=actions.device)

    def select_action(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """One step of algorithm 1 for every row.

        Args:
            batch: the observation, with ``observation.state``, and ``task`` as a list of str.
            **kwargs: ignored; LeRobot's interface allows them.

        Returns:
            Actions (B, 9): poses in metres and unit quaternions xyzw, gripper, collision flag.

        Raises:
            LlakeyError: if the number of rows or the thread changed without a reset, or something in the batch is
                missing or wrong.
        """
        return self.act(self.decide(batch))

    def predict_action_chunk(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """One step as a chunk (B, 1, 9)."""
        return self.select_action(batch)[:, None]

    def _save_pretrained(self, save_directory: Path, state_dict: dict[str, Tensor] | None = None) -> None:
        super()._save_pretrained(save_directory, state_dict=state_dict)
        if self.command is not None and self.command._processor is not None:
            save_assets(Path(save_directory) / ASSETS, self.command.model, self.command._processor)
