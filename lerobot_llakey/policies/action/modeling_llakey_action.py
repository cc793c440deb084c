"""The action policy: from an instruction and RGB-D views to the next keyframe pose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from lerobot.policies.pretrained import PreTrainedPolicy
from torch import Tensor, nn

from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.augmentation import jittered, sample_motion
from lerobot_llakey.policies.action.batch.labels import Labels, moved, read_labels
from lerobot_llakey.policies.action.batch.point_cloud import PointCloud, fuse_views, read_calibration
from lerobot_llakey.policies.action.batch.proprioception import (
    Proprioception,
    proprioception_width,
    read_proprioception,
)
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.dataset_needs import check_training_dataset
from lerobot_llakey.policies.action.designs import DESIGNS, make_pose_head, make_text_encoder
from lerobot_llakey.policies.action.heads.losses import (
    flag_loss,
    heatmap_loss,
    share_right,
    share_turned_less,
    share_within,
)
from lerobot_llakey.policies.action.heads.points import locate, with_prior
from lerobot_llakey.policies.action.heads.pose_heads import PoseOutput
from lerobot_llakey.policies.action.heads.targets import shrinking_sigma
from lerobot_llakey.policies.action.networks.view_network import ViewOutput
from lerobot_llakey.policies.action.parameter_groups import parameter_groups
from lerobot_llakey.policies.action.stage import Stage
from lerobot_llakey.policies.action.text.conditioning import read_texts
from lerobot_llakey.policies.action.text.word_encoder import QueryPool, TextRoles
from lerobot_llakey.policies.action.views.cube import UnitCube
from lerobot_llakey.policies.action.views.scene import Scene
from lerobot_llakey.policies.batch import check_actions, read_hands, read_numbers
from lerobot_llakey.policies.draws import numpy_generator, seeded_by_step
from lerobot_llakey.policies.losses import check_loss, weighted
from lerobot_llakey.policies.precision import autocast
from lerobot_llakey.policies.training_texts import training_texts
from lerobot_llakey.saved.weights import CheckedWeights

CONDITION = 128


class LlakeyActionPolicy(CheckedWeights, PreTrainedPolicy):
    """An RVT-like multi-view policy in one or two stages (LLaKey section III-D; RVT; RVT-2's zoom).

    The first stage sees the whole workspace and locates the next keyframe to about a pixel; the second renders a
    small cube around that point and locates it again. The last stage also predicts rotation, gripper and collision
    flag. Both train together, the second on cubes centred near the true position. The design (:mod:`designs`)
    chooses each stage's network and input channels.

    Args:
        config: the settings.
        dataset_stats: ignored; LeRobot's factory passes it.
        dataset_meta: metadata of the dataset to train on, whose columns are checked.

    Attributes:
        workspace: (3, 2) bounds in metres of the cloud.
        cube: around the workspace; positions inside the network are in its units.
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
        config.learn_robot(dataset_meta)
        config.validate_features()
        config.narrow_features()
        if dataset_meta is not None:
            check_training_dataset(config, dataset_meta)
        self._texts = training_texts(dataset_meta)
        self.design = DESIGNS[config.design]
        proprioception = proprioception_width(config)
        self.register_buffer("workspace", torch.tensor(config.box, dtype=torch.float32), persistent=False)
        self.cube = UnitCube(config.box)
        self.register_buffer("training_step", torch.zeros((), dtype=torch.int64))
        self.text = make_text_encoder(config)
        width = self.text.width
        self.roles = TextRoles(2, width) if config.condition_on == "both" else None
        if self.design.grounded:
            self.sentence = QueryPool(width, 4, 64)
            self.condition = nn.Sequential(
                nn.Linear(256 + proprioception, CONDITION), nn.GELU(), nn.Linear(CONDITION, CONDITION)
            )
        condition = CONDITION if self.design.grounded else proprioception
        self.coarse = Stage(config, condition, width, config.splat_radius[0])
        self.fine = Stage(config, condition, width, config.splat_radius[1]) if config.stages == 2 else None
        network = (self.fine or self.coarse).network
        self.summary = nn.LayerNorm(network.summary_width)
        inputs = len(config.views) * network.feature_width + network.summary_width
        if self.design.grounded:
            inputs += CONDITION + proprioception
        self.pose = make_pose_head(config, inputs)

    def get_optim_params(self) -> list[dict[str, Any]]:
        """Parameter groups, see :func:`parameter_groups`."""
        return parameter_groups(self.named_parameters(), self.config.muon)

    def reset(self) -> None:
        """Nothing to forget: each decision depends on the present observation alone."""

    @seeded_by_step
    def forward(self, batch: dict[str, Any], reduction: str = "mean") -> tuple[Tensor, dict[str, Any]]:
        """The training loss of a batch in the data contract.

        Args:
            batch: observations, texts and ``action`` (B, 9); see :mod:`lerobot_llakey.schema`. The instructions of a
                training dataset are found by ``index`` where the batch has none.
            reduction: "mean" for one number, "none" for one for each row.

        Returns:
            The loss, and figures to log: its parts and how often each part is right.

        Raises:
            LlakeyError: if the batch breaks the data contract, a target lies outside the workspace, or the loss is not
                finite.
        """
        config = self.config
        with torch.autocast(self.workspace.device.type, enabled=False):
            intrinsics, _ = read_calibration(batch, config.cameras)
            action = read_numbers(batch, schema.ACTION, (schema.ACTION_DIM,), rows := len(intrinsics))
            labels = read_labels(action, self.workspace)
            if self.training and (config.augment_translation > 0 or config.augment_yaw > 0):
                hand_columns = config.hand_columns if config.proprioception != "none" else ()
                if hand_columns:
                    read_hands(batch, hand_columns, rows)  # before a motion makes a pose of it
                motion = sample_motion(labels.position, self.workspace, config.augment_translation, config.augment_yaw)
                batch, labels = moved(batch, labels, motion, config.cameras, hand_columns)
            target = self.cube.to_unit(labels.position)
            cloud = fuse_views(batch, config.cameras, self.workspace)
            if self.training:
                cloud = jittered(cloud, len(target), config.colour_jitter)
            hand = read_proprioception(batch, config, rows, config.rotation_blur if self.training else 0.0)
        texts = read_texts(self._texts.fill(batch), config, rows, numpy_generator() if self.training else None)
        with self._autocast():
            scene = self._scene(cloud, hand, texts, labels.lift)
            outputs = {"coarse": (self.coarse(scene, torch.zeros_like(target), 1.0), target)}
            if self.fine is not None:
                low, extent = self.cube.crop(target + self._crop_noise(target), config.crop_size)
                outputs["fine"] = (self.fine(scene, low, extent), (target - low) / extent)
            pose = self._read_pose(*list(outputs.values())[-1], scene, hand, labels.heading, labels.quaternion)
        loss, figures = self._loss(outputs, pose, labels)
        loss = check_loss(weighted(loss, batch))
        if self.training:
            self.training_step += 1
        return (loss if reduction == "none" else loss.mean()), figures

    @torch.no_grad()
    def predict_action_chunk(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """Keyframe actions (B, 1, 9); see :meth:`select_action`."""
        return self.select_action(batch)[:, None]

    @torch.no_grad()
    def select_action(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """The next keyframe for each row: (B, 9) xyz, quaternion xyzw, gripper open, ignore collision.

        Raises:
            LlakeyError: if the batch breaks the data contract, no text is given, or an answer is not finite.
        """
        self.eval()
        config = self.config
        with torch.autocast(self.workspace.device.type, enabled=False):
            cloud = fuse_views(batch, config.cameras, self.workspace)
            rows = len(batch[schema.image_key(config.cameras[0])])
            hand = read_proprioception(batch, config, rows)
        with self._autocast():
            texts = read_texts(batch, config, rows)
            low, extent = torch.zeros(rows, 3, device=self.workspace.device), 1.0
            scene = self._scene(cloud, hand, texts, torch.zeros_like(low))
            coarse = self.coarse(scene, low, extent)
            position = locate(coarse.heatmap, config.views)
            seen, point = coarse, position
            if self.fine is not None:
                low, extent = self.cube.crop(position, config.crop_size)
                seen = self.fine(scene, low, extent)
                point = locate(with_prior(seen.heatmap, coarse.heatmap, low, extent, config.views), config.views)
                position = low + point * extent
            pose = self._read_pose(seen, point, scene, hand, torch.zeros_like(position[:, 0]))
        flags = torch.stack((pose.gripper.argmax(dim=-1), pose.collision.argmax(dim=-1)), dim=-1)
        position = self.cube.from_unit(position)
        return check_actions(torch.cat((position, self.pose.quaternion(pose), flags.to(position)), dim=-1))

    def _autocast(self) -> torch.autocast:
        return autocast(self.config.dtype, self.workspace.device)

    def _crop_noise(self, target: Tensor) -> Tensor:
        if not self.training:
            return torch.zeros_like(target)
        return (torch.rand_like(target) * 2 - 1) * (self.config.crop_noise / self.cube.edge)

    def _scene(self, cloud: PointCloud, hand: Proprioception, texts: Sequence[Sequence[str]], lift: Tensor) -> Scene:
        encoded = [self.text(part) for part in texts]
        words, padding = encoded[0] if self.roles is None else self.roles(encoded)
        condition = hand.vector
        if self.design.grounded:
            sentence = self.sentence(words, padding).flatten(1)
            condition = self.condition(torch.cat((sentence, condition.to(sentence.dtype)), dim=1))
        base = lift / self.cube.edge
        points, effector = self.cube.to_unit(cloud.points), self.cube.to_unit(hand.position)
        return Scene(points, cloud.colours, cloud.rows, base, effector, condition, words, padding)

    def _read_pose(
        self,
        seen: ViewOutput,
        point: Tensor,
        scene: Scene,
        hand: Proprioception,
        heading: Tensor,
        truth: Tensor | None = None,
    ) -> PoseOutput:
        """The pose from the last stage's output, at a point in its cube."""
        parts = [self.design.pool(seen, point, self.config.views), self.summary(seen.summary)]
        if self.design.grounded:
            parts += [scene.condition, hand.vector]
        with torch.autocast(heading.device.type, enabled=False):
            return self.pose(torch.cat([part.float() for part in parts], dim=1), hand.angles, heading, truth)

    def _loss(
        self, outputs: dict[str, tuple[ViewOutput, Tensor]], pose: PoseOutput, labels: Labels
    ) -> tuple[Tensor, dict[str, Any]]:
        """The loss (B,) from each stage's output with the target in its cube, and the figures to log."""
        config, views = self.config, self.config.views
        sigma = shrinking_sigma(
            int(self.training_step), config.heatmap_sigma_start, config.heatmap_sigma_end, config.heatmap_shrink_steps
        )
        parts = {f"{name}_loss": heatmap_loss(seen, point, views, sigma) for name, (seen, point) in outputs.items()}
        parts["rotation_loss"] = self.pose.rotation_loss(pose, labels.quaternion)
        parts["gripper_loss"] = flag_loss(pose.gripper, labels.gripper)
        parts["collision_loss"] = flag_loss(pose.collision, labels.collision)
        loss = torch.stack(list(parts.values())).sum(dim=0)
        figures: dict[str, Any] = {key: value.detach().mean().item() for key, value in parts.items()}
        figures["coarse_within_2cm"] = share_within(*outputs["coarse"], views, 0.02 / self.cube.edge)
        if "fine" in outputs:
            figures["fine_within_5mm"] = share_within(*outputs["fine"], views, 0.005 / config.crop_size)
        figures["rotation_within_5deg"] = share_turned_less(self.pose.quaternion(pose), labels.quaternion, 5.0)
        figures["gripper_right"] = share_right(pose.gripper, labels.gripper)
        return loss, figures
