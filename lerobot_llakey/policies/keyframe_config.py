"""What the settings of all three policies share: one observation in, one keyframe out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lerobot.configs import PreTrainedConfig

from lerobot_llakey import grammar, schema
from lerobot_llakey.bounds import COUNT, SHARE, Bounds, require_settings
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.policies.schedule import WarmupStableDecayConfig

_BOUNDS = {
    "n_obs_steps": Bounds(1, 1, whole=True),
    "scheduler_warmup_steps": COUNT,
    "scheduler_decay_share": SHARE,
}


@dataclass
class KeyframePolicyConfig(PreTrainedConfig):
    """Base of the settings of policies that look at the present frame alone and decide on the next keyframe.

    Attributes:
        scheduler_warmup_steps: steps over which the learning rate rises.
        scheduler_decay_share: share of the training's steps over which it falls to zero at the end.
        grammar: which texts are instructions: "basic", "free", a YAML file, or a grammar's whole data, which a
            checkpoint holds. None takes the training dataset's, and "basic" without one.
    """

    scheduler_warmup_steps: int = 200
    scheduler_decay_share: float = 0.25
    grammar: dict[str, Any] | str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        require_settings(self, _BOUNDS)
        if isinstance(self.grammar, str):
            self.grammar = Grammar.load(self.grammar).to_data()
        self.rules  # noqa: B018  # refuses broken data

    @property
    def rules(self) -> Grammar:
        """The grammar, "basic" where none is set."""
        return Grammar.from_data(self.grammar)

    def learn_grammar(self, features: Mapping[str, Any]) -> None:
        """Take the grammar of a dataset to train on.

        Args:
            features: of the dataset.

        Raises:
            LlakeyError: if another one is set.
        """
        found = grammar.of_features(features, schema.INSTRUCTION)
        if self.grammar is not None and self.rules != found:
            raise LlakeyError(
                f"Expected one grammar in --policy.grammar and the dataset, got {self.rules.name} and {found.name}; "
                "leave --policy.grammar out, or annotate the dataset with llakey annotate --grammar=..."
            )
        self.grammar = found.to_data()

    def get_scheduler_preset(self) -> WarmupStableDecayConfig:
        return WarmupStableDecayConfig(self.scheduler_warmup_steps, self.scheduler_decay_share)

    @property
    def observation_delta_indices(self) -> None:
        return None

    @property
    def action_delta_indices(self) -> None:
        return None

    @property
    def reward_delta_indices(self) -> None:
        return None
