"""Settings of the command policy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from lerobot.configs import FeatureType, NormalizationMode, PolicyFeature, PreTrainedConfig
from lerobot.optim import AdamWConfig

from lerobot_llakey import schema
from lerobot_llakey.bounds import COUNT, SHARE, Bounds, require_settings, require_texts
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat.settings import UNNAMED, ChatSettings
from lerobot_llakey.policies.command.model_settings import ModelSettings
from lerobot_llakey.policies.command.motion_gate import MOVING_ABOVE
from lerobot_llakey.policies.keyframe_config import RobotConfig
from lerobot_llakey.policies.muon import MuonConfig
from lerobot_llakey.policies.precision import PRECISIONS
from lerobot_llakey.saved.own import users_own

_SHOWN = 5
_CHOICES: dict[str, tuple[object, ...]] = {
    "history": (0, 1),
    "proprioception": ("none", "pose"),
    "backend": ("local", "chat"),
    "dtype": PRECISIONS,
    "target": ("instruction", "action"),
}
_BOUNDS: dict[str, Bounds] = {
    "history_dropout": SHARE,
    "action_bins": Bounds(2, 1000, whole=True),
    "hold_above": Bounds(0, open="low", optional=True),
    "max_new_tokens": Bounds(2, 4096, whole=True),
    "shift_pixels": COUNT,
    "colour_jitter": Bounds(0, 1, open="high"),
    "paraphrase_probability": SHARE,
    "optimizer_lr": Bounds(0, open="low", optional=True),
    "optimizer_weight_decay": Bounds(),
    "optimizer_grad_clip_norm": Bounds(),
}


@PreTrainedConfig.register_subclass("llakey_command")
@dataclass
class LlakeyCommandConfig(ModelSettings, RobotConfig):
    """Settings of the vision-language model that names the next basic action (section III-C of the paper).

    Those of ``ModelSettings`` describe the model itself.

    Attributes:
        cameras: whose images the model sees, in this order; see the base class.
        history: 1 adds the instruction last commanded to the prompt ("Previous instruction: ..."), an extension of this
            project; 0 is the paper's prompt.
        history_dropout: probability with which training hides the previous instruction, so that the model learns to use
            the images too.
        proprioception: "none" as in the paper; "pose" adds the hand's pose and the gripper's opening to the prompt as
            numbers (an extension of this project). A chat model never gets them.
        backend: "local" runs the model in this process; "chat" asks the model of that name at ``base_url``, a server of
            the OpenAI-compatible chat-completions API, and trains nothing.
        base_url: address of that server, such as http://127.0.0.1:8000/v1; None is OpenAI's own. The user's own: a
            loaded checkpoint names none, and sends no request before one is given.
        chat: how requests to that server are made.
        dtype: precision of the computations: "bfloat16", "float32", or "auto" for bfloat16 if the weights are in it or
            the device is fast in it, else float32.
        target: what the model answers: "instruction" is the paper's method; "action" its comparison with direct actions
            after RT-2: the next keyframe's pose as numbers, from the task and the images alone, so that the policy acts
            by itself.
        action_bins, workspace: number of values of each of a pose's numbers, and bounds in metres of x, y and z; see
            the base class.
        constrain: answer only with instructions known from training (or listed in ``instructions``), or with legal
            poses if the target is the action.
        hold_above: while a joint moves faster than this, in radians a second by ``observation.velocity``, the arm is on
            its way to a keyframe: the instruction last commanded stays and the model is not asked (an extension of this
            project). With None, or without joints or velocities in the dataset, the model is always asked.
        max_new_tokens: longest answer.
        shift_pixels: training shifts each image by up to this many pixels in each direction.
        colour_jitter: training scales brightness and contrast by up to this share.
        paraphrase_probability: share of training answers that the grammar rewords.
        optimizer_lr: learning rate between warm-up and decay; None is 2e-3 with Muon for the small model and 2e-5 with
            AdamW for a pretrained one.
        optimizer_weight_decay, optimizer_grad_clip_norm, scheduler_warmup_steps: the optimiser's other settings.
        words, instructions: the small model's vocabulary and the known answers; filled from the training dataset.
    """

    history: int = 1
    history_dropout: float = 0.3
    proprioception: str = "none"

    backend: str = "local"
    base_url: str | None = users_own(None, unset=UNNAMED)
    chat: ChatSettings = field(default_factory=ChatSettings)

    dtype: str = "auto"
    target: str = "instruction"
    action_bins: int = 256
    constrain: bool = True
    hold_above: float | None = MOVING_ABOVE
    max_new_tokens: int = 48

    shift_pixels: int = 4
    colour_jitter: float = 0.1
    paraphrase_probability: float = 0.0

    optimizer_lr: float | None = None
    optimizer_weight_decay: float = 0.05
    optimizer_grad_clip_norm: float = 1.0
    scheduler_warmup_steps: int = 100

    words: list[str] = field(default_factory=list)
    instructions: list[str] = field(default_factory=list)

    output_features: dict[str, PolicyFeature] | None = field(default_factory=dict)
    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: dict.fromkeys(("VISUAL", "STATE", "ACTION"), NormalizationMode.IDENTITY)
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        require_settings(self, _BOUNDS)
        self.check_texts()
        for name, choices in _CHOICES.items():
            if (value := getattr(self, name)) not in choices:
                raise LlakeyError(
                    f"Expected `{name}` out of {', '.join(map(str, choices))}, got {value!r}; choose one of them."
                )
        if self.target == "action" and (self.backend == "chat" or not self.constrain):
            raise LlakeyError(
                "Expected backend=local and constrain=true with target=action, got others; only then every answer is a "
                "pose."
            )
        if self.backend == "local" and self.base_url == UNNAMED:
            self.base_url = None
        self.check_model_settings()
        if self.dtype == "float32" and self.weights_dtype != "float32":
            raise LlakeyError(
                f"Expected float32 weights with dtype=float32, got {self.weights_dtype} weights; set dtype=auto."
            )

    def check_texts(self) -> None:
        """Refuse an unsorted vocabulary, and known answers outside the grammar.

        Raises:
            LlakeyError: naming what was expected and what came.
        """
        require_texts("words", self.words)
        require_texts("instructions", self.instructions)
        if self.words != sorted(self.words):
            raise LlakeyError(
                "Expected words in alphabetical order, in which the weights know them, got "
                f"{', '.join(self.words[:_SHOWN])}, ...; take the checkpoint's own or sort them."
            )
        wrong = [text for text in self.instructions if not self.rules.is_parsable(text)]
        if self.target == "instruction" and wrong:
            raise LlakeyError(
                f"Expected instructions of {self.rules.name}, got {len(wrong)} outside it "
                f"({', '.join(repr(text[:60]) for text in wrong[:_SHOWN])}), which would never be carried "
                "out; reword them, add a template, or choose --policy.grammar=free."
            )

    @property
    def image_keys(self) -> list[str]:
        """Feature names of the cameras' images, in their order."""
        return [schema.image_key(camera) for camera in self.cameras]

    @property
    def needs_workspace(self) -> bool:
        return self.uses_proprioception or self.target == "action"

    @property
    def uses_proprioception(self) -> bool:
        """Whether the prompt contains the hand's pose."""
        return self.proprioception == "pose" and self.backend == "local"

    def validate_features(self) -> None:
        """Check that every camera is among the input features, and the hand, if it is used, among the state's names.

        Raises:
            LlakeyError: if one is missing.
        """
        visual = {key for key, feature in (self.input_features or {}).items() if feature.type is FeatureType.VISUAL}
        missing = [key for key in self.image_keys if key not in visual]
        if missing:
            raise LlakeyError(
                f"Expected the images {self.image_keys} among the input features, got {sorted(visual)} without "
                f"{missing}; set `cameras` to some that are there."
            )
        if self.uses_proprioception:
            _ = self.hand_columns

    def use_default_features(self) -> None:
        """Set the contract's input and output features if none were given."""
        shape = (3, self.image_size, self.image_size)
        if not self.input_features:
            self.input_features = {key: PolicyFeature(FeatureType.VISUAL, shape) for key in self.image_keys}
        if not self.output_features:
            self.output_features = {schema.ACTION: PolicyFeature(FeatureType.ACTION, (schema.ACTION_DIM,))}

    def get_optimizer_preset(self) -> MuonConfig | AdamWConfig:
        settings: dict[str, Any] = {
            "betas": (0.9, 0.98),
            "weight_decay": self.optimizer_weight_decay,
            "grad_clip_norm": self.optimizer_grad_clip_norm,
        }
        if self.model is None:
            return MuonConfig(lr=2e-3 if self.optimizer_lr is None else self.optimizer_lr, **settings)
        return AdamWConfig(lr=2e-5 if self.optimizer_lr is None else self.optimizer_lr, **settings)
