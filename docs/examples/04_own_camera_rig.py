"""An arm of six joints with two cameras of different sizes: a policy finds everything by name.

The network is not trained; the point is what it is given. From the repository root:
python docs/examples/04_own_camera_rig.py
"""

import torch
from lerobot.configs import FeatureType, PolicyFeature

from lerobot_llakey import schema
from lerobot_llakey.policies.action.batch.point_cloud import fuse_views
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy

RIG = {  # name: height, width, focal length in pixels, place in the base frame (both look straight down)
    "top": (480, 640, 616.0, (0.45, 0.0, 0.9)),
    "side": (240, 424, 300.0, (0.35, -0.2, 0.6)),
}
STATE = [*(f"joint_{number}" for number in range(1, 7)), "qw", "qx", "qy", "qz", "x", "y", "z", "gripper_opening"]


def main() -> None:
    torch.manual_seed(0)
    joints, turn, place, gripper = [0.1] * 6, [0.0, 1.0, 0.0, 0.0], [0.4, 0.0, 0.3], [1.0]
    batch = {schema.STATE: torch.tensor([joints + turn + place + gripper])}
    for camera, (height, width, focal, eye) in RIG.items():
        batch[schema.image_key(camera)] = torch.rand(1, 3, height, width)
        batch[schema.depth_key(camera)] = torch.full((1, 1, height, width), 1000.0 * eye[2])  # a bare table at z = 0
        batch[schema.intrinsics_key(camera)] = torch.tensor([[focal, focal, width / 2, height / 2]])
        batch[schema.extrinsics_key(camera)] = torch.tensor([[*eye, 1.0, 0.0, 0.0, 0.0]])
    features = {
        key: PolicyFeature(FeatureType.VISUAL if "images" in key else FeatureType.STATE, tuple(value.shape[1:]))
        for key, value in batch.items()
    }
    workspace = [[0.1, 0.8], [-0.4, 0.4], [-0.05, 0.35]]  # training on a dataset finds it, and the names, by itself
    for cameras in (["top"], ["side"], ["side", "top"]):
        cloud = fuse_views(batch, cameras, torch.tensor(workspace))
        low, high = cloud.points.amin(dim=0).tolist(), cloud.points.amax(dim=0).tolist()
        print(f"{' and '.join(cameras):13} {len(cloud.points):6} points, x {low[0]:.2f} to {high[0]:.2f} m", end="")
        print(f", y {low[1]:.2f} to {high[1]:.2f} m, z {low[2]:.3f} to {high[2]:.3f} m")
    config = LlakeyActionConfig(
        input_features=features, cameras=["side", "top"], state_names=STATE, workspace=workspace, device="cpu"
    )
    config.output_features = {schema.ACTION: PolicyFeature(FeatureType.ACTION, (schema.ACTION_DIM,))}
    policy = LlakeyActionPolicy(config).eval()
    action = policy.select_action(batch | {schema.INSTRUCTION: ["grasp the red block"]})[0]
    print(dict(zip(schema.ACTION_NAMES, (round(number, 3) for number in action.tolist()), strict=True)))


if __name__ == "__main__":
    main()
