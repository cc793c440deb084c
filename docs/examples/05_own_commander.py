"""Your own commander in place of the command policy: anything that says the next instruction from an observation.

From the repository root: python docs/examples/05_own_commander.py
"""

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey.policies.hierarchy.commanders import Commander, Said
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.sim.env import LlakeySimEnv


class DrawerRules(Commander):
    """Opens the drawer that the task names, by rules. A planner, a language model or a person fits in just as well."""

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        return [Said(self._next(batch["task"][row], last), "rules") for row, last in zip(rows, previous, strict=True)]

    def _next(self, task: str, last: str) -> str:
        which = next(drawer for drawer in ("bottom", "middle", "top") if drawer in task)
        if not last:
            return f"move to the front of the {which} handle"
        if last.startswith("move"):
            return f"grasp the {which} handle"
        return f"pull the {which} drawer open"


def main() -> None:
    agent = Agent.load("checkpoints/llakey_small")
    agent.policy.loop.commander = DrawerRules()
    env = LlakeySimEnv("open_drawer", split="val", episode_length=6)
    for seed in range(2):
        print(f"scene {seed}")
        episode = run_episode(env, agent, seed)
        print("   " + "\n   ".join(episode.instructions))
        print(f"   {episode.description}: {'done' if episode.success else 'not done'}")
    env.close()


if __name__ == "__main__":
    main()
