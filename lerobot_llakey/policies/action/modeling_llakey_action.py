"""The action policy: from an instruction and RGB-D views to the next keyframe pose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from lerobot.policies.pretrained import PreTrainedPolicy
from torch import Tensor, nn
from torch.nn import functional as F

from lerobot_llakey import schema
from lerobot_llakey.policies.action.augmentation import sample_motion
from lerobot_llakey.policies.action.conditioning import read_texts, reworded
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.heads import PoseHead, features_at, locate
from lerobot_llakey.policies.action.network import ViewOutput
from lerobot_llakey.policies.action.point_cloud import PointCloud, fuse_views, inside
from lerobot_llakey.policies.action.renderer import project
from lerobot_llakey.policies.action.stage import Scene, Stage
from lerobot_llakey.policies.action.targets import (
    angle_bins,
    angles_to_quaternion,
    bin_angles,
    heat_target,
    quaternion_to_angles,
    shrinking_sigma,
)
from lerobot_llakey.policies.action.text import QueryPool, TextEncoder

CONDITION = 128
PROPRIOCEPTION = 7
"""Gripper opening, and sine and cosine of the present hand's three angles."""


class LlakeyActionPolicy(PreTrainedPolicy):
    """An RVT-like multi-view policy in two stages (LLaKey section III-D; RVT-2's zoom).

    The first stage looks at the whole workspace and finds the next keyframe's place to about a centimetre; the second
    renders a small cube around it and gives place, rotation, gripper and collision flag. Both are trained at once by
    cross-entropy alone: the second's cube is centred near the true place. There is no timestep input.

    Args:
        config: the settings.
        dataset_stats: ignored; LeRobot's factory passes it.
        dataset_meta: metadata of the dataset to train on, whose columns are checked.
    """

    config_class = LlakeyActionConfig
    name = "llakey_action"
    config: LlakeyActionConfig
    workspace: Tensor
    training_step: Tensor

    def __init__(
        self, config: LlakeyActionConfig, dataset_stats: Any = None, dataset_meta: Any = None, **kwargs: Any
    ) -> None:
        super().__init__(config)
        config.validate_features()
        config.narrow_features()
        if dataset_meta is not None:
            config.validate_instructions(dataset_meta.features)
        views = len(config.views)
        self.register_buffer("workspace", torch.tensor(config.workspace, dtype=torch.float32), persistent=False)
        self.register_buffer("training_step", torch.zeros((), dtype=torch.int64))
        self.text = TextEncoder(config.text_width, config.text_layers, config.text_buckets, config.text_length)
        self.sentence = QueryPool(config.text_width, 4, 64)
        self.condition = nn.Sequential(
            nn.Linear(256 + PROPRIOCEPTION, CONDITION), nn.GELU(), nn.Linear(CONDITION, CONDITION)
        )
        self.coarse = Stage(config, CONDITION, config.splat_radius[0])
        self.fine = Stage(config, CONDITION, config.splat_radius[1])
        inputs = views * config.widths[0] + config.widths[2] + CONDITION + PROPRIOCEPTION
        self.summary = nn.LayerNorm(config.widths[2])
        self.pose = PoseHead(inputs, config.rotation_bins)
        self._rng = np.random.default_rng()

    def get_optim_params(self) -> list[dict[str, Any]]:
        """Parameter groups: matrices decay, vectors (biases, norms) do not."""
        named = [parameter for parameter in self.parameters() if parameter.requires_grad]
        return [
            {"params": [parameter for parameter in named if parameter.ndim >= 2]},
            {"params": [parameter for parameter in named if parameter.ndim < 2], "weight_decay": 0.0},
        ]

    def reset(self) -> None:
        """Nothing to forget: each decision depends on the present observation alone."""

    def forward(self, batch: dict[str, Any], reduction: str = "mean") -> tuple[Tensor, dict[str, Any]]:
        """The training loss of a batch in the data contract.

        Args:
            batch: observations, texts and ``action`` (B, 9); see :mod:`lerobot_llakey.schema`.
            reduction: "mean" for one number, "none" for one for each row.

        Returns:
            The loss, and figures to log: its parts and how often each part is right.

        Raises:
            ValueError: if the batch breaks the data contract or a target lies outside the workspace.
        """
        config = self.config
        with torch.autocast(self.workspace.device.type, enabled=False):
            position, quaternion = self._targets(batch[schema.ACTION])
            effector = batch[schema.STATE].float() if config.use_state else None
            heading, lift = torch.zeros_like(position[:, 0]), torch.zeros_like(position)
            if self.training and (config.augment_translation > 0 or config.augment_yaw > 0):
                motion = sample_motion(position, self.workspace, config.augment_translation, config.augment_yaw)
                heading, lift = motion.yaw, motion.translation
                if schema.EXTRINSICS in batch:
                    batch = batch | {schema.EXTRINSICS: motion.move_cameras(batch[schema.EXTRINSICS].float())}
                position, quaternion = position + motion.translation, motion.move_quaternion(quaternion)
                if effector is not None:
                    tcp = motion.move_points(effector[:, schema.POSITION])
                    turned = motion.move_quaternion(effector[:, schema.QUATERNION])
                    effector = torch.cat((tcp, turned, effector[:, schema.GRIPPER :]), dim=1)
            target = self._to_unit(position)
            cloud = fuse_views(batch, config.cameras, self.workspace)
        texts = read_texts(batch, config)
        if self.training:
            texts = [reworded(text, config.paraphrase_probability, self._rng) for text in texts]
        with self._autocast():
            scene, proprioception = self._scene(cloud, effector, texts, lift)
            coarse = self.coarse(scene, torch.zeros_like(target), 1.0)
            low, extent = self._crop(target + self._crop_noise(target))
            fine = self.fine(scene, low, extent)
            local = (target - low) / extent
            angles, gripper, collision = self._read_pose(fine, local, scene, proprioception, heading)
        sigma = shrinking_sigma(
            int(self.training_step), config.heat_sigma_start, config.heat_sigma_end, config.heat_shrink_steps
        )
        if self.training:
            self.training_step += 1
        action = batch[schema.ACTION]
        bins = angle_bins(quaternion_to_angles(quaternion), config.rotation_bins)
        parts = {
            "coarse_loss": self._heat_loss(coarse, target, sigma),
            "fine_loss": self._heat_loss(fine, local, sigma),
            "rotation_loss": F.cross_entropy(angles.flatten(0, 1), bins.flatten(), reduction="none").view(-1, 3).sum(1),
            "gripper_loss": F.cross_entropy(gripper, (action[:, schema.GRIPPER] > 0.5).long(), reduction="none"),
            "collision_loss": F.cross_entropy(
                collision, (action[:, schema.IGNORE_COLLISION] > 0.5).long(), reduction="none"
            ),
        }
        loss = (
            config.position_weight * (parts["coarse_loss"] + parts["fine_loss"])
            + config.rotation_weight * parts["rotation_loss"]
            + config.gripper_weight * parts["gripper_loss"]
            + config.collision_weight * parts["collision_loss"]
        )
        figures: dict[str, Any] = {key: value.detach().mean().item() for key, value in parts.items()}
        figures["coarse_within_2cm"] = self._within(coarse, target, 0.02)
        figures["fine_within_5mm"] = self._within(fine, local, 0.005 / extent)
        figures["rotation_right"] = (angles.argmax(-1) == bins).all(dim=1).float().mean().item()
        figures["gripper_right"] = (gripper.argmax(-1) == (action[:, schema.GRIPPER] > 0.5)).float().mean().item()
        if config.weight_key in batch:
            loss = loss * batch[config.weight_key].to(loss).reshape(len(loss))
        return (loss if reduction == "none" else loss.mean()), figures

    @torch.no_grad()
    def predict_action_chunk(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """Keyframe actions (B, 1, 9); see :meth:`select_action`."""
        return self.select_action(batch)[:, None]

    @torch.no_grad()
    def select_action(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """The next keyframe for each row: (B, 9) xyz, quaternion xyzw, gripper open, ignore collision.

        Raises:
            ValueError: if the batch breaks the data contract or no text is given.
        """
        self.eval()
        config = self.config
        with torch.autocast(self.workspace.device.type, enabled=False):
            cloud = fuse_views(batch, config.cameras, self.workspace)
            effector = batch[schema.STATE].float() if config.use_state else None
        with self._autocast():
            texts = read_texts(batch, config)
            whole = torch.zeros(len(texts), 3, device=self.workspace.device)
            scene, proprioception = self._scene(cloud, effector, texts, whole)
            centre = locate(self.coarse(scene, whole, 1.0).heat, config.views)
            low, extent = self._crop(centre)
            fine = self.fine(scene, low, extent)
            local = locate(fine.heat, config.views)
            heading = torch.zeros_like(local[:, 0])
            angles, gripper, collision = self._read_pose(fine, local, scene, proprioception, heading)
        position = self._from_unit(low + local * extent)
        quaternion = angles_to_quaternion(bin_angles(angles.argmax(dim=-1), config.rotation_bins))
        flags = torch.stack((gripper.argmax(dim=-1), collision.argmax(dim=-1)), dim=-1)
        return torch.cat((position, quaternion, flags.to(position)), dim=-1)

    def _autocast(self) -> torch.autocast:
        enabled = self.config.dtype == "bfloat16"
        return torch.autocast(self.workspace.device.type, dtype=torch.bfloat16, enabled=enabled)

    def _to_unit(self, position: Tensor) -> Tensor:
        return (position - self.workspace[:, 0]) / (self.workspace[:, 1] - self.workspace[:, 0])

    def _from_unit(self, position: Tensor) -> Tensor:
        return position * (self.workspace[:, 1] - self.workspace[:, 0]) + self.workspace[:, 0]

    def _crop(self, centre: Tensor) -> tuple[Tensor, float]:
        extent = self.config.crop_size / float((self.workspace[:, 1] - self.workspace[:, 0]).mean())
        return centre - extent / 2, extent

    def _crop_noise(self, target: Tensor) -> Tensor:
        if not self.training:
            return torch.zeros_like(target)
        share = self.config.crop_noise / (self.workspace[:, 1] - self.workspace[:, 0])
        return (torch.rand_like(target) * 2 - 1) * share

    def _targets(self, action: Tensor) -> tuple[Tensor, Tensor]:
        position, quaternion = action[:, schema.POSITION].float(), action[:, schema.QUATERNION].float()
        outside = ~inside(position, self.workspace)
        if outside.any():
            row = int(outside.nonzero()[0])
            raise ValueError(
                f"Expected keyframes inside the workspace {self.workspace.tolist()} (metres), got "
                f"{[round(number, 3) for number in position[row].tolist()]} in {schema.ACTION} at batch row {row}; "
                "widen policy.workspace."
            )
        return position, F.normalize(quaternion, dim=-1)

    def _scene(
        self, cloud: PointCloud, effector: Tensor | None, texts: Sequence[str], lift: Tensor
    ) -> tuple[Scene, Tensor]:
        words, padding = self.text(texts)
        rows = len(texts)
        if effector is None:
            place = torch.full((rows, 3), torch.nan, device=words.device)
            proprioception = torch.zeros(rows, PROPRIOCEPTION, device=words.device)
        else:
            place = self._to_unit(effector[:, schema.POSITION])
            angles = quaternion_to_angles(F.normalize(effector[:, schema.QUATERNION], dim=-1))
            opening = effector[:, schema.GRIPPER, None]
            proprioception = torch.cat((opening, angles.sin(), angles.cos()), dim=1)
        sentence = self.sentence(words, padding).flatten(1)
        condition = self.condition(torch.cat((sentence, proprioception.to(sentence.dtype)), dim=1))
        points = self._to_unit(cloud.points)
        base = lift / (self.workspace[:, 1] - self.workspace[:, 0])
        return Scene(points, cloud.colours, cloud.rows, base, place, condition, words, padding), proprioception

    def _read_pose(
        self, fine: ViewOutput, local: Tensor, scene: Scene, proprioception: Tensor, heading: Tensor
    ) -> tuple[Tensor, Tensor, Tensor]:
        there = features_at(fine.features, local, self.config.views)
        parts = (there, self.summary(fine.summary), scene.condition, proprioception)
        present = torch.atan2(proprioception[:, 1:4], proprioception[:, 4:7])
        return self.pose(torch.cat([part.float() for part in parts], dim=1), present, heading)

    def _heat_loss(self, output: ViewOutput, point: Tensor, sigma: float) -> Tensor:
        target = heat_target(project(point, self.config.views), self.config.view_size, sigma)
        logs = output.heat.flatten(2).log_softmax(dim=-1)
        return -(target.flatten(2) * logs).sum(dim=-1).mean(dim=1)

    def _within(self, output: ViewOutput, point: Tensor, distance: float) -> float:
        """Share of views whose hottest pixel lies within a distance (in units of the stage's cube) of the target."""
        size = self.config.view_size
        best = output.heat.detach().flatten(2).argmax(dim=-1)
        spot = torch.stack((best // size, best % size), dim=-1).add(0.5) / size
        offset = (spot - project(point, self.config.views)).norm(dim=-1)
        return (offset <= distance).float().mean().item()
