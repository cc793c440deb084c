"""What the shipped policy says and does for one picture of the simulator.

From the repository root: python docs/examples/01_policy_on_one_observation.py
"""

import torch
from lerobot.envs.utils import preprocess_observation

from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from lerobot_llakey.sim.configuration_llakey_sim import LlakeySimConfig

TASK = "open_drawer"


def main() -> None:
    policy = LlakeyPolicy.from_pretrained("checkpoints/llakey_small")
    env = LlakeySimConfig(task=TASK, split="val").create_envs(n_envs=1)[TASK][0]
    observation, _ = env.reset(seed=[3])

    # A batch is a dictionary of tensors (rows, ...) and lists of texts: lerobot_llakey/schema.py names its keys.
    batch = preprocess_observation(observation)
    batch["task"] = list(env.get_attr("task_description"))
    for key, value in batch.items():
        print(f"{key:45}", tuple(value.shape) if isinstance(value, torch.Tensor) else value)

    policy.reset()  # before every episode
    action = policy.select_action(batch)[0]
    *pose, gripper_open, ignore_collision = action.tolist()
    print("\nnext instruction:", policy.last_instructions[0])
    print("hand goes to x y z:", [round(metres, 3) for metres in pose[:3]])
    print("with quaternion xyzw:", [round(part, 3) for part in pose[3:]])
    print("then the gripper is", "open" if gripper_open else "closed")
    print("on the way the planner", "may" if ignore_collision else "may not", "touch things")
    env.close()


if __name__ == "__main__":
    main()
