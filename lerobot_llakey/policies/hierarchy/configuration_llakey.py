"""Settings of the hierarchical policy: a command policy, an action policy and the loop that joins them."""

from __future__ import annotations

from dataclasses import dataclass, field

from lerobot.configs import FeatureType, NormalizationMode, PreTrainedConfig

from lerobot_llakey import instructions
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.keyframe_config import KeyframePolicyConfig
from lerobot_llakey.policies.muon import MuonConfig

COMMANDERS = ("policy", "oracle", "task")


@PreTrainedConfig.register_subclass("llakey")
@dataclass
class LlakeyConfig(KeyframePolicyConfig):
    """Settings of LLaKey as a whole (section III and algorithm 1 of the paper).

    Attributes:
        command: settings of the command policy; those of ``command_path`` take their place when it is given.
        action: settings of the action policy; those of ``action_path`` take their place when it is given.
        command_path, action_path: Hub names or folders of trained parts. Once loaded they are cleared, because a saved
            checkpoint holds both parts.
        commander: who gives the instructions: "policy" is the command policy, "oracle" the expert's instruction that
            the environment sends along, "task" the skill instruction itself, without a hierarchy. With the last two no
            command policy is built or loaded.
        repeat_threshold: how often the same instruction may be repeated before random moves begin.
        random_move_probability: chance of a random move at each step after that.
        random_move_radius: metres around the gripper within which a random move ends.
        fallback_instruction: done where nothing valid was ever commanded.
        seed: of the random moves.
        train_command, train_action: which parts ``lerobot-train`` trains; the other is frozen.
        command_lr_multiplier, action_lr_multiplier: factors on the learning rates that the parts' own settings give.
        optimizer_grad_clip_norm: largest norm of both parts' gradients together.
    """

    command: LlakeyCommandConfig = field(default_factory=lambda: LlakeyCommandConfig(device="cpu"))
    action: LlakeyActionConfig = field(default_factory=lambda: LlakeyActionConfig(device="cpu"))
    command_path: str | None = None
    action_path: str | None = None

    commander: str = "policy"
    repeat_threshold: int = 3
    random_move_probability: float = 0.5
    random_move_radius: float = 0.1
    fallback_instruction: str = "raise the robotic arm"
    seed: int = 0

    train_command: bool = True
    train_action: bool = True
    command_lr_multiplier: float = 1.0
    action_lr_multiplier: float = 1.0
    optimizer_grad_clip_norm: float = 5.0

    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: {kind.value: NormalizationMode.IDENTITY for kind in FeatureType}
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.commander not in COMMANDERS:
            raise ValueError(f"Expected a commander out of {COMMANDERS}, got {self.commander!r}; pick one of these.")
        if self.repeat_threshold < 0 or self.random_move_radius < 0 or not 0 <= self.random_move_probability <= 1:
            raise ValueError(
                "Expected repeat_threshold >= 0, random_move_radius >= 0 and random_move_probability in [0, 1], got "
                f"{self.repeat_threshold}, {self.random_move_radius} and {self.random_move_probability}; correct them."
            )
        if not (self.train_action or (self.train_command and self.commander == "policy")):
            raise ValueError(
                "Expected at least one part to train, got none; set train_command or train_action to true."
            )
        instructions.parse(self.fallback_instruction)
        self.command.device = self.action.device = self.device

    @property
    def has_command(self) -> bool:
        """Whether the policy holds a command policy."""
        return self.commander == "policy"

    def validate_features(self) -> None:
        """The parts check their own features when they are built."""

    def get_optimizer_preset(self) -> MuonConfig:
        """Muon on the groups that ask for it, AdamW on the rest; the groups carry the parts' own rates and decays."""
        preset = self.action.get_optimizer_preset()
        return MuonConfig(
            lr=preset.lr * self.action_lr_multiplier,
            betas=preset.betas,
            weight_decay=preset.weight_decay,
            grad_clip_norm=self.optimizer_grad_clip_norm,
        )
