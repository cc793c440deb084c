"""Settings of the command policy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from lerobot.configs import FeatureType, NormalizationMode, PolicyFeature, PreTrainedConfig
from lerobot.optim import AdamWConfig

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat.settings import UNNAMED, ChatSettings
from lerobot_llakey.policies.command.holding import MOVING_ABOVE
from lerobot_llakey.policies.command.limits import check_numbers, check_texts
from lerobot_llakey.policies.command.pretrained.settings import PretrainedModelSettings
from lerobot_llakey.policies.keyframe_config import RobotConfig
from lerobot_llakey.policies.muon import MuonConfig
from lerobot_llakey.policies.precision import PRECISIONS
from lerobot_llakey.saved.own import users_own


@PreTrainedConfig.register_subclass("llakey_command")
@dataclass
class LlakeyCommandConfig(PretrainedModelSettings, RobotConfig):
    """Settings of the vision-language model that names the next basic action (section III-C of the paper).

    Those of ``PretrainedModelSettings`` say which model it starts from and what of it is trained.

    Attributes:
        cameras: whose images are shown to the model, in this order; see the base class.
        history: 1 tells the model the instruction last commanded ("Previous instruction: ..."), an extension of this
            project; 0 is the paper's prompt.
        history_dropout: probability with which training hides the previous instruction, so that the images are
            read too.
        proprioception: what is told of the robot beside the images: "none" as in the paper, or the hand's "pose" and
            the gripper's opening as numbers (an extension of this project). A chat model is told nothing of it.
        backend: "local" runs the model in this process; "chat" asks the model of that name at ``base_url``, a server of
            the OpenAI-compatible chat-completions API, and trains nothing.
        base_url: address of that server, such as http://127.0.0.1:8000/v1; None is OpenAI's own. The user's own: in a
            loaded checkpoint none is named, and nothing is asked before one is given.
        chat: how it is asked.
        image_size: pixels a side; other sizes are resized. Pretrained models use their own image processor instead.
        patch_size: pixels a side of one image token.
        vision_width, vision_layers, vision_heads: the small CLIP vision tower.
        text_width, text_layers, text_heads: the small Llama language model.
        auxiliary_weight: weight of a training aid for the small model, which also regresses where the gripper is and
            where the next keyframe is from the state and the action of each sample. Not in the paper; 0 leaves it out.
        dtype: precision of the computations: "bfloat16", "float32", or "auto" for bfloat16 where the weights are or the
            device is fast in it, float32 elsewhere.
        target: what is answered: "instruction" is the paper's method; "action" is its attempt at direct actions after
            RT-2: the next keyframe's pose as numbers, from the task and the images alone, so that the policy acts by
            itself.
        action_bins, workspace: of a pose's numbers: how many values each has, and bounds in metres of x, y and z; see
            the base class.
        constrain: answer only with instructions known from training (or given in ``instructions``), and with legal
            poses where the target is the action.
        hold_above: while a joint turns faster than this, in radians a second by ``observation.velocity``, the arm is on
            its way to a keyframe: the instruction last commanded holds and the model is not asked (an extension of this
            project). None always asks, and so does a robot that tells no joints or no velocity.
        max_new_tokens: longest answer.
        shift_pixels: training shifts each image by up to this many pixels each way.
        colour_jitter: training scales brightness and contrast by up to this share.
        paraphrase_probability: share of training answers worded anew by the grammar.
        optimizer_lr: learning rate between its rise and its fall; None takes 2e-3 with Muon for the small
            model and 2e-5 with AdamW for a pretrained one.
        optimizer_weight_decay, optimizer_grad_clip_norm, scheduler_warmup_steps: the rest of the optimiser's settings.
        words, instructions: the small model's vocabulary and the known answers; filled from the training dataset.
    """

    history: int = 1
    history_dropout: float = 0.3
    proprioception: str = "none"

    backend: str = "local"
    base_url: str | None = users_own(None, unset=UNNAMED)
    chat: ChatSettings = field(default_factory=ChatSettings)

    image_size: int = schema.IMAGE_SIZE
    patch_size: int = 16
    vision_width: int = 192
    vision_layers: int = 4
    vision_heads: int = 6
    text_width: int = 256
    text_layers: int = 4
    text_heads: int = 4

    auxiliary_weight: float = 0.5

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
        check_numbers(self)
        check_texts(self)
        if self.history not in (0, 1):
            raise LlakeyError(f"Expected `history` to be 0 or 1, got {self.history}; only one instruction is kept.")
        if self.proprioception not in ("none", "pose"):
            raise LlakeyError(
                f"Expected `proprioception` none or pose, got {self.proprioception!r}; choose one of them."
            )
        if self.backend not in ("local", "chat"):
            raise LlakeyError(f"Expected `backend` local or chat, got {self.backend!r}; choose one of them.")
        if self.dtype not in PRECISIONS:
            raise LlakeyError(f"Expected `dtype` out of {', '.join(PRECISIONS)}, got {self.dtype!r}; choose one.")
        if self.target not in ("instruction", "action"):
            raise LlakeyError(f"Expected `target` instruction or action, got {self.target!r}; choose one of them.")
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
        if self.image_size % self.patch_size:
            raise LlakeyError(
                f"Expected `image_size` to be a multiple of `patch_size`, got {self.image_size} and {self.patch_size}; "
                "change one of them."
            )

    @property
    def image_keys(self) -> list[str]:
        """Feature names of the cameras' images, in their order."""
        return [schema.image_key(camera) for camera in self.cameras]

    @property
    def needs_workspace(self) -> bool:
        return self.tells_state or self.target == "action"

    @property
    def tells_state(self) -> bool:
        """Whether the prompt tells the robot's state."""
        return self.proprioception == "pose" and self.backend == "local"

    def validate_features(self) -> None:
        """Check that every camera is among the input features, and the hand among the state's names where it is told.

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
        if self.tells_state:
            _ = self.hand_columns

    def use_default_features(self) -> None:
        """Fill in the contract's input and output features where none were given."""
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
