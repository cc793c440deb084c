"""A part keeps good episodes only, and says what it threw away."""

import json
from collections import Counter
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.datasets import collect_part
from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.plan import ATTEMPTS, CollectSettings, Targets
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.recorder import Episode, record
from lerobot_llakey.sim.simulation import Simulation


def test_bad_episodes_are_thrown_away_counted_and_made_up_for(
    settings: CollectSettings, targets: Targets, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unlucky(simulation: Simulation, seed: int, variation: int, fps: float, disturbance: str | None) -> Episode:
        episode = record(simulation, seed, variation, fps, disturbance)
        return replace(episode, keyframes_match=episode.keyframes_match and seed % ATTEMPTS >= 2)

    monkeypatch.setattr(collect_part, "record", unlucky)
    discarded = collect(replace(settings, num_episodes=1), targets, num_workers=1, progress=lambda *_: None)
    assert Counter(discarded).total() >= 2
    assert set(discarded) <= {f"open_drawer: {why}" for why in ("keyframes differ from the waypoints", "not done")}
    assert targets.keysteps is not None
    said = json.loads((targets.keysteps / "meta" / "llakey_collect.json").read_text())
    assert said["discarded"] == discarded and said["episodes"] == 1
    dataset = LeRobotDataset("local/any", root=targets.keysteps)
    assert (np.array(dataset.hf_dataset[schema.EPISODE_SEED]) % ATTEMPTS >= 2).all()


def test_an_expert_that_always_fails_is_named(
    settings: CollectSettings, targets: Targets, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(simulation: Simulation, seed: int, variation: int, fps: float, disturbance: str | None) -> Episode:
        empty = np.zeros((1, len(schema.SIM_STATE_NAMES)), dtype=np.float32)
        return Episode(empty, empty, empty, [], [], False, False, "open_drawer", "", seed, variation, 0)

    monkeypatch.setattr(collect_part, "record", broken)
    with pytest.raises(LlakeyError, match="expert of open_drawer to do variation 0"):
        collect(settings, targets, num_workers=1, progress=lambda *_: None)


def test_recovery_demonstrations_hold_the_way_back(settings: CollectSettings, targets: Targets) -> None:
    collect(replace(settings, num_episodes=2, recovery=1.0), targets, num_workers=1, progress=lambda *_: None)
    dataset = LeRobotDataset("local/any", root=targets.keysteps)
    columns = dataset.hf_dataset
    for episode in range(2):
        rows = [row for row in range(len(columns)) if int(columns[row]["episode_index"]) == episode]
        said = [columns[row][schema.INSTRUCTION] for row in rows]
        assert len({text for text in said if text.startswith("move to the front of")}) == 1
        switches = [b for a, b in pairwise(said) if a != b]
        assert sum(text.startswith("move to the front of") for text in switches) == 1
