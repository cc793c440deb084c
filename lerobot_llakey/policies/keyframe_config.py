"""What the settings of all three policies share: one observation in, one keyframe out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from lerobot.configs import PolicyFeature, PreTrainedConfig

from lerobot_llakey import grammar, schema
from lerobot_llakey.bounds import COUNT, Bounds, require_box, require_settings, require_texts
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.hand import further_columns, hand_columns, names_of
from lerobot_llakey.policies.schedule import WarmupStableDecayConfig
from lerobot_llakey.policies.workspace import keyframe_box

AUTO = "auto"
_BOUNDS = {
    "n_obs_steps": Bounds(1, 1, whole=True),
    "scheduler_warmup_steps": COUNT,
}


@dataclass
class KeyframePolicyConfig(PreTrainedConfig):
    """Base of the settings of policies that look at the present frame alone and decide on the next keyframe.

    Attributes:
        scheduler_warmup_steps: steps over which the learning rate rises.
        grammar: which texts are instructions: "basic", "free", a YAML file, or a grammar's whole data, which a
            checkpoint holds. None takes the training dataset's, and "basic" without one.
    """

    scheduler_warmup_steps: int = 200
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
        return WarmupStableDecayConfig(self.scheduler_warmup_steps)

    @property
    def observation_delta_indices(self) -> None:
        return None

    @property
    def action_delta_indices(self) -> None:
        return None

    @property
    def reward_delta_indices(self) -> None:
        return None


@dataclass
class RobotConfig(KeyframePolicyConfig):
    """Base of the settings that name a robot's cameras, state and workspace, which the training dataset may tell.

    Attributes:
        cameras: names of the cameras, in any order and number; empty takes all that fit, and is filled from the dataset
            when training starts.
        state_names: of the numbers in ``observation.state``, in their order; filled from the dataset when training
            starts. The hand is found by them, see :mod:`lerobot_llakey.hand`.
        workspace: bounds ((x), (y), (z)) in metres, base frame, of all keyframes; "auto" is the box around the
            dataset's keyframes, and is replaced by it when training starts.
    """

    input_features: dict[str, PolicyFeature] | None = field(default_factory=dict)

    cameras: list[str] = field(default_factory=list)
    state_names: list[str] = field(default_factory=list)
    workspace: list[list[float]] | str = AUTO

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check()

    def check(self) -> None:
        """Refuse settings that make no sense; called again once they were filled from a dataset.

        Raises:
            LlakeyError: naming what was expected and what came.
        """
        require_texts("cameras", self.cameras)
        require_texts("state_names", self.state_names)
        if isinstance(self.workspace, str) and self.workspace != AUTO:
            raise LlakeyError(
                f"Expected workspace as three (low, high) pairs in metres or {AUTO!r}, got {self.workspace!r}; correct "
                "it."
            )
        if not isinstance(self.workspace, str):
            require_box("workspace", self.workspace, schema.FARTHEST)

    @property
    def needs_depth(self) -> bool:
        """Whether a camera is of use only with depth and calibration."""
        return False

    @property
    def needs_workspace(self) -> bool:
        """Whether the workspace is read."""
        return True

    def learn_robot(self, dataset_meta: Any | None) -> None:
        """Fill in what was left to the training dataset; the names of the state are always the dataset's.

        Args:
            dataset_meta: a ``LeRobotDatasetMetadata``; None takes the cameras of the input features.

        Raises:
            LlakeyError: if there is no camera that fits, or no keyframe to tell the workspace by.
        """
        features: Mapping[str, Any] = (self.input_features or {}) if dataset_meta is None else dataset_meta.features
        self.cameras = self.cameras or list(schema.cameras_of(features, depth=self.needs_depth))
        if dataset_meta is not None and schema.STATE in features:
            self.state_names = names_of(features[schema.STATE])
            inputs = self.input_features or {}
            if schema.STATE in inputs:  # of a policy that is trained on, on another robot
                self.input_features = {**inputs, schema.STATE: self.state_feature(inputs[schema.STATE])}
        if dataset_meta is not None and self.needs_workspace and self.workspace == AUTO:
            self.workspace = keyframe_box(dataset_meta)
        self.check()
        require_texts("cameras", self.cameras, some=True)

    def state_feature(self, like: PolicyFeature) -> PolicyFeature:
        """The input feature of the state, with as many numbers as it has names."""
        return PolicyFeature(like.type, (len(self.state_names),))

    @property
    def box(self) -> schema.Workspace:
        """The workspace.

        Raises:
            LlakeyError: if it is still to be told by a dataset.
        """
        if isinstance(self.workspace, str):
            raise LlakeyError(
                f"Expected workspace as three (low, high) pairs in metres, got {self.workspace!r} without a dataset to "
                "train on; give policy.workspace."
            )
        return cast(schema.Workspace, tuple((float(low), float(high)) for low, high in self.workspace))

    @property
    def hand_columns(self) -> tuple[int, ...]:
        """Where the hand stands among the state's numbers.

        Raises:
            LlakeyError: if the names do not tell.
        """
        return hand_columns(self.state_names)

    @property
    def joints(self) -> int:
        """How many further numbers the state has, and so how many velocities before the gripper's."""
        return len(further_columns(self.state_names)) if self.state_names else 0
