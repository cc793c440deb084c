"""Settings of the action policy: instruction and RGB-D views in, next keyframe pose out."""

from __future__ import annotations

from dataclasses import dataclass, field

from lerobot.configs import PreTrainedConfig
from lerobot.configs.types import FeatureType, NormalizationMode, PolicyFeature
from lerobot.optim import AdamWConfig

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.limits import FRAMES, check_settings
from lerobot_llakey.policies.keyframe_config import RobotConfig
from lerobot_llakey.policies.muon import MuonConfig
from lerobot_llakey.saved.own import names_weights


@PreTrainedConfig.register_subclass("llakey_action")
@dataclass
class LlakeyActionConfig(RobotConfig):
    """An RVT-like keyframe policy (LLaKey section III-D; RVT; RVT-2 for the zoomed second stage).

    ``configs/`` holds the settings of RVT and RVT-2 as published; the defaults are the shipped policy's.

    Attributes:
        design: the network: "small", "rvt" or "rvt2", see :mod:`designs`.
        stages: 2 to look again, at a crop around the first stage's point; 1 to read the pose at the first look.
        cameras: names of the RGB-D cameras that are fused into the cloud; see the base class.
        workspace: of the cloud too; the views show the cube around it, see :mod:`views.cube`.
        views: virtual orthographic views that are rendered, names of :data:`views.renderer.VIEWS` in its order.
        view_size: height and width of a rendered view in pixels, a multiple of 16 ("small") or of ``patch_size``.
        crop_size: edge in metres of the cube around the first stage's point that the second stage renders.
        crop_noise: the training crops are centred on the target plus uniform noise up to this, in metres.
        splat_radius: pixels by which points grow, for the first and the second stage.
        condition_on: which text steers the policy: the basic action's instruction, the skill's task, or both.
        proprioception: what of the present hand the policy is conditioned on: its "pose" and gripper opening, as in RVT
            the opening of its "gripper" alone, or "none" of it.
        rotation_blur: degrees, standard deviation about each axis, of the noise that training adds to the hand's
            orientation in the proprioception. A policy that trusts an exact orientation learns to keep one that it
            should correct; a policy without it cannot see which way round a symmetric hand is.
        use_timestep: also condition on the number of actions taken so far (``observation.step``), as RVT does.
        rotation: "bins" predicts the three angles apart, "sequential_bins" about x, then y, then z, each knowing those
            before it (RVT-2), "sixd" a continuous rotation (Zhou et al. 2019).
        rotation_bins: bins for each of the three angles over a full turn; 72 are 5 degrees each.
        rotation_frames: frames that vote for the rotation, out of "view", "hand" and "base"; RVT's know "view" alone.
        text_model: a text model on the Hub or in a folder, frozen, whose features are kept for each text; None for
            the word-level encoder trained along, with text_width, text_layers, text_buckets and text_length (words).
        colour_queries: "small": text-conditioned colour channels added to every rendered pixel.
        widths: "small": channels at 1/4, 1/8 and 1/16 of the view size.
        blocks: "small": convolutional blocks at 1/4 and 1/8, on the way down; one each on the way up.
        patch_size, token_width, attention_dropout: "rvt" and "rvt2": pixels along a patch, and of the transformer.
        transformer_layers, transformer_heads: the multi-view transformer, of "small" at 1/16.
        heatmap_sigma_start, heatmap_sigma_end: standard deviation in pixels of the heatmaps' target, shrinking linearly
            over ``heatmap_shrink_steps`` training steps, then constant.
        augment_translation: metres along each axis; ``augment_yaw``: degrees about z.
        colour_jitter: by what share training changes colours.
        paraphrase_probability: share of training texts that are replaced by a synonym.
        dtype: precision of the computations: "bfloat16", "float32", or "auto" for the one that is fast on the device;
            weights stay in float32.
        muon: train the hidden matrices and kernels with Muon rather than with AdamW, see :mod:`muon`.
    """

    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: {kind.value: NormalizationMode.IDENTITY for kind in FeatureType}
    )

    design: str = "small"
    stages: int = 2
    views: list[str] = field(default_factory=lambda: ["top", "front", "side"])
    view_size: int = 80
    crop_size: float = 0.2
    crop_noise: float = 0.035
    splat_radius: list[int] = field(default_factory=lambda: [0, 1])

    condition_on: str = "instruction"
    proprioception: str = "pose"
    rotation_blur: float = 25.0
    use_timestep: bool = False
    rotation: str = "bins"
    rotation_bins: int = 72
    rotation_frames: list[str] = field(default_factory=lambda: list(FRAMES))

    text_model: str | None = names_weights()
    text_width: int = 128
    text_layers: int = 2
    text_buckets: int = 1024
    text_length: int = 32
    colour_queries: int = 8
    widths: list[int] = field(default_factory=lambda: [64, 128, 192])
    blocks: list[int] = field(default_factory=lambda: [1, 2])
    patch_size: int = 14
    token_width: int = 512
    attention_dropout: float = 0.0
    transformer_layers: int = 3
    transformer_heads: int = 6

    heatmap_sigma_start: float = 3.0
    heatmap_sigma_end: float = 1.0
    heatmap_shrink_steps: int = 1500
    augment_translation: float = 0.06
    augment_yaw: float = 20.0
    colour_jitter: float = 0.0
    paraphrase_probability: float = 0.1
    dtype: str = "auto"

    muon: bool = True
    optimizer_lr: float = 1.5e-3
    optimizer_weight_decay: float = 1e-2
    optimizer_grad_clip_norm: float = 5.0
    scheduler_warmup_steps: int = 100

    def check(self) -> None:
        super().check()
        check_settings(self)

    @property
    def needs_depth(self) -> bool:
        return True

    def get_optimizer_preset(self) -> AdamWConfig | MuonConfig:
        kind = MuonConfig if self.muon else AdamWConfig
        return kind(
            lr=self.optimizer_lr,
            weight_decay=self.optimizer_weight_decay,
            grad_clip_norm=self.optimizer_grad_clip_norm,
            betas=(0.9, 0.98),
        )

    def required_features(self) -> list[str]:
        """Names of the observation features that the policy reads at every frame."""
        parts = (schema.image_key, schema.depth_key, schema.intrinsics_key, schema.extrinsics_key)
        keys = [part(camera) for camera in self.cameras for part in parts]
        keys += [schema.STATE] if self.proprioception != "none" else []
        return [*keys, schema.STEP] if self.use_timestep else keys

    def validate_features(self) -> None:
        """Check that the features of a dataset or environment are those that the policy reads.

        Raises:
            LlakeyError: if a camera, its calibration, the state or the action is missing, the action is of another
                shape, or the hand is not among the state's names.
        """
        inputs: dict[str, PolicyFeature] = self.input_features or {}
        missing = [key for key in self.required_features() if key not in inputs]
        if missing == [schema.STEP]:
            raise LlakeyError(
                f"Expected the column {schema.STEP} (keyframe actions taken so far) for policy.use_timestep, got none; "
                "annotate the dataset anew or set policy.use_timestep=false."
            )
        if missing:
            raise LlakeyError(
                f"Expected the features {', '.join(missing)} for the cameras {', '.join(self.cameras)}, got only "
                f"{', '.join(sorted(inputs)) or 'none'}; use a dataset with RGB-D cameras or set policy.cameras."
            )
        if self.proprioception != "none":
            _ = self.hand_columns
        action = self.action_feature
        if action is not None and tuple(action.shape) != (schema.ACTION_DIM,):
            raise LlakeyError(
                f"Expected actions of {schema.ACTION_DIM} numbers ({', '.join(schema.ACTION_NAMES)}), got shape "
                f"{tuple(action.shape)}; use a keysteps dataset."
            )

    def narrow_features(self) -> None:
        """Keep the input features that the policy reads: LeRobot's normaliser cannot bear columns of text."""
        required = self.required_features()
        inputs: dict[str, PolicyFeature] = self.input_features or {}
        self.input_features = {key: value for key, value in inputs.items() if key in required}

    def validate_instructions(self, features: dict[str, object]) -> None:
        """Check that a dataset to train on has the instruction column.

        Raises:
            LlakeyError: if the policy is conditioned on instructions and the dataset has none.
        """
        if self.condition_on != "task" and schema.INSTRUCTION not in features:
            raise LlakeyError(
                f"Expected the column {schema.INSTRUCTION}, got a dataset without instruction columns; annotate it or "
                "train with policy.condition_on=task."
            )
