"""``llakey demo``: watch a trained policy do the tasks: a table of successes, and videos.

llakey demo --policy_path=checkpoints/llakey_small --task=open_drawer,close_jar,move_block --output_dir=outputs/demo
llakey demo --policy_path=expert --task=all --disturbance=drop
"""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.cli.output import write_results
from lerobot_llakey.parallel import kept, run_jobs
from lerobot_llakey.rollout.actors import Actor, Agent, Expert
from lerobot_llakey.rollout.episode import Episode, run_episode, success_table
from lerobot_llakey.rollout.video import EpisodeVideo
from lerobot_llakey.saved.folder import inspect_checkpoint
from lerobot_llakey.sim.env import LlakeySimEnv
from lerobot_llakey.sim.perturbations.registry import check_disturbance
from lerobot_llakey.sim.tasks import parse_tasks

_EXPERT = "expert"


@dataclass
class DemoConfig:
    """Options of ``llakey demo``.

    Attributes:
        policy_path: checkpoint folder or Hub name, or expert for the scripted demonstrators.
        task: task names separated by commas, or all.
        num_episodes: episodes of each task.
        num_videos: episodes of each task, the first ones, of which a video is made.
        first_seed: index of the first scene within the split.
        split: of the scene seeds: train, val or test.
        disturbance: what disturbs each episode: drop, block, shift, empty_grasp or execution_noise; none where empty.
        oracle: let the expert say the instructions, so that only the action policy is shown.
        detailed: show the robot's detailed meshes in the videos.
        num_workers: processes that run episodes at the same time; one for each CPU core where 0.
        output_dir: folder for results.json and videos/.
        overrides: settings of the policy by dotted name, such as '{command.base_url: "http://127.0.0.1:8000/v1"}': what
            a checkpoint says of servers, variables and paths is not taken.
    """

    policy_path: str = "checkpoints/llakey_small"
    task: str = "all"
    num_episodes: int = 2
    num_videos: int = 1
    first_seed: int = 0
    split: str = "test"
    disturbance: str = ""
    oracle: bool = False
    detailed: bool = True
    num_workers: int = 2
    output_dir: Path = Path("outputs/demo")
    overrides: dict[str, Any] = field(default_factory=dict)


def run(config: DemoConfig) -> list[Episode]:
    """Run all episodes, showing progress; write videos and ``results.json``.

    Raises:
        MissingFileError: if there is no checkpoint at the path.
        LlakeyError: if a task is unknown.
    """
    tasks = parse_tasks(config.task)
    check_disturbance(config.disturbance)
    if config.policy_path != _EXPERT:
        inspect_checkpoint(config.policy_path)  # before a process is started for it
    jobs = [(config, task, index) for index in range(config.num_episodes) for task in tasks]
    (config.output_dir / "videos").mkdir(parents=True, exist_ok=True)
    episodes = []
    with tqdm(total=len(jobs), desc="episodes", unit="episode") as progress:
        for episode in run_jobs(_episode, jobs, config.num_workers):
            episodes.append(episode)
            progress.update()
            progress.set_postfix(solved=f"{sum(e.success for e in episodes)}/{len(episodes)}")
    episodes.sort(key=lambda episode: (tasks.index(episode.task), episode.seed))
    write_results(config.output_dir, {"episodes": [asdict(episode) for episode in episodes]})
    return episodes


def _episode(config: DemoConfig, task: str, index: int) -> Episode:
    recorded = index < config.num_videos
    env = LlakeySimEnv(
        task,
        config.split,
        oracle_instructions=config.oracle,
        detailed=recorded and config.detailed,
        disturbance=config.disturbance,
    )
    seed = config.first_seed + index
    actor: Actor = Expert()
    if config.policy_path != _EXPERT:
        actor = kept(Agent.load, config.policy_path, config.oracle, config.overrides)
    video = EpisodeVideo()
    episode = run_episode(env, actor, seed, [video] if recorded else [])
    if recorded:
        name = f"{task}_{seed:03d}_{'success' if episode.success else 'failure'}.mp4"
        video.save(config.output_dir / "videos" / name)
    env.close()
    return episode


@with_options
def show(config: DemoConfig) -> None:
    """Run the episodes, then print the table."""
    print(success_table(run(config)))
    print(f"videos: {(config.output_dir / 'videos').resolve()}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        show()
