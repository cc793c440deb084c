"""What an action policy sees and decides for one frame: cloud, virtual views, heatmaps and pose."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import torch
from lerobot.utils.collate import lerobot_collate_fn
from torch import Tensor, nn
from torch.utils.data import Dataset

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.geometry import rotation_error
from lerobot_llakey.policies.action.batch.point_cloud import fuse_views
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.action.stage import Stage
from lerobot_llakey.policies.action.views.renderer import gather_pixels, splat
from lerobot_llakey.policies.prepared import Preprocessor, prepared


@dataclass(frozen=True)
class StageTrace:
    """What one stage sees.

    Attributes:
        name: "coarse" or "fine".
        views: names of the V virtual views.
        images: (V, S, S, 3) in 0..1, zero where nothing is seen.
        heatmap: (V, S, S) probability of each pixel, summing to one in a view.
        low: (3,) metres, lower corner of the rendered box.
        extent: (3,) metres, its edges.
    """

    name: str
    views: tuple[str, ...]
    images: Tensor
    heatmap: Tensor
    low: Tensor
    extent: Tensor

    def local(self, position: Tensor) -> Tensor:
        """A place (3,) in metres as coordinates of the rendered box's unit cube."""
        return (position - self.low) / self.extent


@dataclass(frozen=True)
class Trace:
    """One decision, and the truth beside it; all on the CPU.

    Attributes:
        task: the skill instruction.
        instruction: the basic action's instruction, "" where the dataset has none.
        cameras: name -> RGB image (H, W, 3) in 0..1.
        points: (M, 3) of the cloud in metres, base frame.
        colours: (M, 3) in 0..1.
        stages: what each stage saw.
        predicted: (9,) the action decided on.
        true: (9,) the recorded one.
        said: what a hierarchical policy's command part would have said; "" without one.
    """

    task: str
    instruction: str
    cameras: dict[str, Tensor]
    points: Tensor
    colours: Tensor
    stages: list[StageTrace]
    predicted: Tensor
    true: Tensor
    said: str = ""

    def errors(self) -> dict[str, float]:
        """Position error in ``centimetres``, rotation error in ``degrees``; ``gripper`` and ``collision``: 1 if right.

        A parallel gripper is the same after half a turn, as in ``llakey keyframe-accuracy``.
        """
        quaternions = [action[None, schema.QUATERNION] for action in (self.true, self.predicted)]
        right = (self.predicted > 0.5) == (self.true > 0.5)
        return {
            "centimetres": 100 * float((self.predicted - self.true)[schema.POSITION].norm()),
            "degrees": float(rotation_error(*quaternions)),
            "gripper": float(right[schema.GRIPPER]),
            "collision": float(right[schema.IGNORE_COLLISION]),
        }


def trace(
    policy: nn.Module,
    dataset: Dataset[Any],
    index: int,
    preprocessor: Preprocessor | None = None,
) -> Trace:
    """Let an action policy decide on a recorded frame, and keep what its stages saw.

    Args:
        policy: an action policy, or a hierarchical one, whose action part is looked into as it acts on the recorded
            instruction; its command part is asked what it would have said.
        dataset: keysteps or demonstrations in the data contract.
        index: of the frame.
        preprocessor: the policy's, where it has one.

    Raises:
        LlakeyError: if the policy is of another kind, the index lies outside the dataset, or the frame breaks the
            data contract.
    """
    action_policy = getattr(policy, "action", policy)
    if not isinstance(action_policy, LlakeyActionPolicy):
        raise LlakeyError(
            f"Expected an llakey_action policy or an llakey one with an action part, got {type(policy).__name__}; "
            "give --policy_path such a checkpoint."
        )
    size = len(dataset)  # type: ignore[arg-type]
    if not 0 <= index < size:
        raise LlakeyError(f"Expected an index in [0, {size}), got {index}; choose a frame of the dataset.")
    batch: dict[str, Any] = lerobot_collate_fn([dataset[index]])
    words = {key: str(batch[key][0]) if key in batch else "" for key in (schema.TASK, schema.INSTRUCTION)}
    true = batch[schema.ACTION][0].float().cpu()
    batch = prepared(batch, preprocessor)
    config, command = action_policy.config, getattr(policy, "command", None)
    with torch.no_grad(), _watched(action_policy) as stages:
        predicted = action_policy.select_action(batch)[0].float().cpu()
        said = command.next_instructions(batch)[0] if command is not None else ""
        cloud = fuse_views(batch, config.cameras, action_policy.workspace)
    images = {name: batch[schema.image_key(name)][0].float().permute(1, 2, 0).cpu() for name in config.cameras}
    task, instruction = words.values()
    return Trace(task, instruction, images, cloud.points.cpu(), cloud.colours.cpu(), stages, predicted, true, said)


@contextmanager
def _watched(policy: LlakeyActionPolicy) -> Iterator[list[StageTrace]]:
    """What the policy's stages see within the context, in the order in which they run."""
    stages: list[StageTrace] = []
    handles = []
    for name in ("coarse", "fine"):
        stage = getattr(policy, name)
        if stage is not None:
            handles.append(stage.register_forward_hook(_keep(name, policy, stages)))
    try:
        yield stages
    finally:
        for handle in handles:
            handle.remove()


def _keep(name: str, policy: LlakeyActionPolicy, stages: list[StageTrace]) -> Callable[[Stage, Any, Any], None]:
    def keep(stage: Stage, inputs: Any, output: Any) -> None:
        scene, low, extent = inputs
        local = (scene.points - low[scene.rows]) / extent
        index = splat(local, scene.rows, len(low), stage.views, stage.size, stage.splat_radius)
        heatmap = output.heatmap[0].float().flatten(1).softmax(dim=1).view(index.shape[1:])
        corner = policy.cube.from_unit(low[0])
        shown = gather_pixels(scene.colours, index)[0].float()
        size = torch.full_like(corner, policy.cube.edge * extent)
        stages.append(StageTrace(name, stage.views, shown.cpu(), heatmap.cpu(), corner.cpu(), size.cpu()))

    return keep
