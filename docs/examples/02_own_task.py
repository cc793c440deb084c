"""A task of your own in the simulator: its scene, when it is done, and an expert that demonstrates it.

From the repository root: python docs/examples/02_own_task.py
"""

import mujoco
import numpy as np

from lerobot_llakey.geometry import Pose, top_down
from lerobot_llakey.instructions import instruct
from lerobot_llakey.rollout.actors import Expert
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.objects.blocks import BLOCK, add_block
from lerobot_llakey.sim.tasks import register_task
from lerobot_llakey.sim.tasks.base import Task, Waypoint
from lerobot_llakey.sim.tasks.grasping import grasping
from lerobot_llakey.sim.world import World


@register_task  # from now on --env.task and --task know it, wherever this module has been imported
class LiftBlock(Task):
    """Lift the block of the named colour."""

    name = "lift_block"
    variations = 2
    colours = ("red", "blue")

    def build(self, spec: mujoco.MjSpec) -> None:
        for colour in self.colours:
            add_block(spec, colour)

    def reset(self, world: World, variation: int) -> None:
        self.variation, self.colour = variation, self.colours[variation]
        self.description = f"lift the {self.colour} block"
        for side, colour in zip((-0.15, 0.15), self.colours, strict=True):
            world.place(f"{colour}_block", Pose(np.array([world.rng.uniform(0.4, 0.55), side, BLOCK])))

    def success(self, world: World) -> bool:
        return bool(world.pose(f"{self.colour}_block").position[2] > 0.15)

    def plan(self, world: World) -> list[Waypoint]:
        grasp = Pose(world.pose(f"{self.colour}_block").position, top_down())
        lift = Waypoint(grasp.shifted(z=0.2), False, False, instruct("raise"))
        if world.holds(f"{self.colour}_block"):
            return [] if self.success(world) else [lift]
        return [*grasping(world, grasp.shifted(z=0.1), grasp, "top", f"the {self.colour} block"), lift]


def main() -> None:
    env = LlakeySimEnv("lift_block", split="train")
    for seed in range(3):
        episode = run_episode(env, Expert(), seed)
        print(f"{episode.description}: {' -> '.join(episode.instructions)}, solved: {episode.success}")
    env.close()


if __name__ == "__main__":
    main()
