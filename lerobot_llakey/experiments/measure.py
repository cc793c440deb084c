"""A short measurement of this machine: a few episodes collected, a few training steps, an episode evaluated."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy, make_pre_post_processors
from lerobot.utils.collate import lerobot_collate_fn
from torch.utils.data import DataLoader

from lerobot_llakey.datasets.collect import collect, quieten
from lerobot_llakey.datasets.keysteps import convert
from lerobot_llakey.datasets.plan import CollectSettings, Targets
from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.files import reading, write_whole
from lerobot_llakey.policies.hierarchy.compose import compose
from lerobot_llakey.rollout.actors import Agent
from lerobot_llakey.rollout.episode import run_episode
from lerobot_llakey.rollout.video import EpisodeVideo
from lerobot_llakey.sim.env import LlakeySimEnv

_FILE = "measured.json"
_EPISODES, _STEPS, _ACTIONS = 2, 2, 3


def measured(folder: Path, tasks: Sequence[str], trainings: Mapping[str, Training], command: str, action: str) -> Rates:
    """The rates here, measured once for a folder and its trainings.

    Args:
        folder: where they are kept.
        tasks: the first of them is collected and evaluated.
        trainings: by name.
        command: name of the training of a command policy.
        action: name of the training of an action policy.
    """
    path = folder / _FILE
    key = {"task": tasks[0], "trainings": {name: _signature(training) for name, training in trainings.items()}}
    if path.exists():
        with reading(path, "record of rates"):
            found = json.loads(path.read_text())
            if found["of"] == key:
                return Rates(**found["rates"])
    rates = _measure(tasks[0], trainings, command, action)
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps({"of": key, "rates": asdict(rates)}, indent=2))
    return rates


def _measure(task: str, trainings: Mapping[str, Training], command: str, action: str) -> Rates:
    start, cores = time.process_time(), os.cpu_count() or 1  # so far mostly importing, as a training's process will
    quieten()
    with TemporaryDirectory() as name:
        folder = Path(name)
        demonstrations, keysteps = folder / "demonstrations", folder / "keysteps"
        settings = CollectSettings((task,), _EPISODES, "val")
        collect(CollectSettings((task,), 1, "val"), Targets(None, folder / "first"), 1, _silent)  # builds the scene
        each = _timed(lambda: collect(settings, Targets(None, folder / "direct"), 1, _silent)) / _EPISODES
        written = _timed(lambda: collect(settings, Targets(demonstrations, None), 1, _silent)) / _EPISODES
        source = LeRobotDataset("local/demonstrations", root=demonstrations)
        drawn = _timed(lambda: convert(source, keysteps, "local/keysteps")) / _EPISODES
        dataset = LeRobotDataset("local/keysteps", root=keysteps)
        seconds: dict[str, float] = {}
        known: dict[str, float] = {}
        for training_name, training in trainings.items():
            signature = _signature(training)
            if signature not in known:
                kept = folder / training_name if training_name in (command, action) else None
                known[signature] = _step_seconds(training, dataset, kept)
            seconds[training_name] = known[signature]
        acting, answering, filming = _decisions(task, folder / command, folder / action, folder)
    return Rates(written, drawn, each, start, seconds, acting, answering, filming, cores)


def _silent(kept: int, discarded: int) -> None:
    """In place of a progress bar."""


def _signature(training: Training) -> str:
    """What a training's speed depends on."""
    return f"{training.settings.recipe} {training.batch_size} {training.device} {training.settings.arguments}"


def _step_seconds(training: Training, dataset: LeRobotDataset, folder: Path | None) -> float:
    """Seconds of a training step, loading its samples included where the same process does that."""
    config = training.config()
    assert config.policy is not None
    policy = make_policy(config.policy, ds_meta=dataset.meta)
    preprocessor, _ = make_pre_post_processors(config.policy, dataset_stats=dataset.meta.stats)
    optimizer = config.policy.get_optimizer_preset().build(policy.get_optim_params())
    loader = DataLoader(dataset, config.batch_size, shuffle=True, collate_fn=lerobot_collate_fn)
    loading = _timed(lambda: next(iter(loader)))
    batch = preprocessor(next(iter(loader)))

    def step() -> None:
        optimizer.zero_grad()
        policy.forward(batch)[0].backward()
        for one in optimizer.values() if isinstance(optimizer, dict) else [optimizer]:
            one.step()

    policy.train()
    step()

    def steps() -> None:
        for _ in range(_STEPS):
            step()

    computing = _timed(steps, training.device) / _STEPS
    if folder is not None:
        policy.save_pretrained(folder)
    workers = config.num_workers
    return max(computing, loading / workers) if workers else computing + loading


def _decisions(task: str, command: Path, action: Path, folder: Path) -> tuple[float, float, float]:
    """Seconds of an action in an episode, of one answer of the command policy, and of an action recorded."""
    compose(command, action, folder / "llakey", repeat_threshold=0)
    agent = Agent.load(folder / "llakey")
    env = LlakeySimEnv(task, "val", episode_length=_ACTIONS, oracle_instructions=True)
    run_episode(env, agent, 0)
    acting = _timed(lambda: run_episode(env, agent, 1)) / _ACTIONS
    observation, _ = env.reset(seed=0)
    batch: dict[str, Any] = agent.batch(env.task_description, observation)
    policy: Any = agent.policy
    with torch.inference_mode():
        answering = _timed(lambda: policy.command.next_instructions(batch))

    def filming() -> None:
        video = EpisodeVideo()
        run_episode(env, agent, 1, [video])
        video.save(folder / "video.mp4")

    recorded = _timed(filming) / _ACTIONS
    env.close()
    return acting, answering, recorded


def _timed(work: Any, device: str = "cpu") -> float:
    start = time.perf_counter()
    work()
    if device.startswith("cuda"):
        torch.cuda.synchronize()
    return time.perf_counter() - start
