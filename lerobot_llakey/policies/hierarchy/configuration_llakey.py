"""Settings of the hierarchical policy: a command policy, an action policy and the loop that joins them."""

from __future__ import annotations

from dataclasses import dataclass, field

from lerobot.configs import FeatureType, NormalizationMode, PreTrainedConfig

from lerobot_llakey.bounds import COUNT, POSITIVE, SHARE, Bounds, require_settings, require_texts
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import FREE, Grammar
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.keyframe_config import KeyframePolicyConfig
from lerobot_llakey.policies.muon import MuonConfig
from lerobot_llakey.saved.own import users_own
from lerobot_llakey.schema import FARTHEST

COMMANDERS = ("policy", "oracle", "task", "list")
BOUNDS: dict[str, Bounds] = {
    "repeat_threshold": COUNT,
    "random_move_probability": SHARE,
    "random_move_radius": Bounds(0, FARTHEST),
    "seed": COUNT,
    "command_lr_multiplier": POSITIVE,
    "action_lr_multiplier": POSITIVE,
    "optimizer_grad_clip_norm": Bounds(),
}
"""What a number may be."""


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
            the environment sends along, "task" the skill instruction itself, without a hierarchy, "list" those of
            ``instructions``. With the last three no command policy is built or loaded.
        instructions: of the commander "list": one a step, from the start of each episode, the last one over and over.
        repeat_threshold: how often the same instruction may be repeated before random moves begin.
        random_move_probability: chance of a random move at each step after that.
        random_move_radius: metres around the gripper within which a random move ends.
        fallback_instruction: done where nothing valid was ever commanded. None takes the grammar's plain move straight
            up ("raise the robotic arm"); where it has none, the arm keeps still and an error says so.
        screw_about_tool_axis: let a hand that is told to screw turn about and move along its own z axis only.
        raise_upward: let a hand that is told to raise itself move straight up only.
        seed: of the random moves, together with the first observation of each episode: the same
            seed and scene give the same moves in any batch. Repeat an evaluation with another seed.
        log_dir: folder for a record of every step, one file of JSON lines an episode; none is written by default.
        results_path: ``results.json`` of an evaluation, whose table goes on the model card when the policy is pushed;
            one in the folder that the policy was loaded from is found without it.
        train_command, train_action: which parts ``lerobot-train`` trains; the other is frozen.
        command_lr_multiplier, action_lr_multiplier: factors on the learning rates that the parts' own settings give.
        optimizer_grad_clip_norm: largest norm of both parts' gradients together.
    """

    command: LlakeyCommandConfig = field(default_factory=lambda: LlakeyCommandConfig(device="cpu"))
    action: LlakeyActionConfig = field(default_factory=lambda: LlakeyActionConfig(device="cpu"))
    command_path: str | None = users_own(None)
    action_path: str | None = users_own(None)

    commander: str = "policy"
    instructions: list[str] = field(default_factory=list)
    repeat_threshold: int = 3
    random_move_probability: float = 0.5
    random_move_radius: float = 0.1
    fallback_instruction: str | None = None
    screw_about_tool_axis: bool = False
    raise_upward: bool = False
    seed: int = 0
    log_dir: str | None = users_own(None)
    results_path: str | None = users_own(None)

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
            raise LlakeyError(f"Expected a commander out of {COMMANDERS}, got {self.commander!r}; pick one of these.")
        require_settings(self, BOUNDS)
        require_texts("instructions", list(dict.fromkeys(self.instructions)))  # one may come again and again
        if self.commander == "list" and not self.instructions:
            raise LlakeyError("Expected at least one instruction for commander='list', got none; set instructions.")
        if not (self.train_action or (self.train_command and self.commander == "policy")):
            raise LlakeyError(
                "Expected at least one part to train, got none; set train_command or train_action to true."
            )
        self.share_grammar()
        self.command.device = self.action.device = self.device

    def share_grammar(self) -> None:
        """Give the parts one grammar: that of whoever has one.

        Raises:
            LlakeyError: if two have different ones, or instructions in the settings are outside it.
        """
        sharing = [self, self.action, *([self.command] if self.has_command else [])]
        found = [one.rules for one in sharing if one.grammar is not None]
        if differing := [other for other in found if other != found[0]]:
            raise LlakeyError(
                f"Expected one grammar in the policy and its parts, got {found[0].name} and {differing[0].name}; set "
                "--policy.grammar to that of both parts, or train them with the same one."
            )
        for one in sharing:
            one.grammar = found[0].to_data() if found else None
        for text in filter(None, (self.fallback_instruction, *self.instructions)):
            self.rules.parse(text)

    @property
    def spoken(self) -> Grammar:
        """The grammar of what the commander says: any sentence where the task itself commands."""
        return Grammar.load(FREE) if self.commander == "task" else self.rules

    @property
    def fallback(self) -> str | None:
        """What is done where nothing valid was ever commanded, None to keep still."""
        plain = [name for name in self.rules.straight_up if not self.rules.slots(name)]
        return self.fallback_instruction or (self.rules.instruct(plain[0]) if plain else None)

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
