"""State is kept per row: a batch of episodes goes as the same episodes one by one, with the shipped weights."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from lerobot.configs import PreTrainedConfig

from fakes import fake_frame
from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

TOLERANCE = 1e-5  # of metres and quaternions; the size of a batch decides in which order sums are taken
CHECKPOINT = Path(__file__).parents[3] / "checkpoints/llakey_small"
TASKS = ("close the red jar", "open the top drawer", "move the red block to the purple target", "close the blue jar")
EPISODES, STEPS = 8, 5


@pytest.fixture(scope="module")
def shipped() -> LlakeyPolicy:
    """The shipped policy, quick to despair: without a pause it repeats itself, stalls and moves at random."""
    settings = ["--device=cpu", "--repeat_threshold=0", "--random_move_probability=0.6"]
    settings += ["--command.dtype=float32", "--action.dtype=float32"]  # in bfloat16 the last digits are tenths of a mm
    config = PreTrainedConfig.from_pretrained(CHECKPOINT, cli_overrides=settings)
    return LlakeyPolicy.from_pretrained(CHECKPOINT, config=config)


def _episode(seed: int) -> list[dict[str, Any]]:
    """Observations of an episode, the same scene from start to end; the hand moves in every second step only."""
    rng = np.random.default_rng(seed)
    frame = fake_frame(rng, schema.IMAGE_SIZE)
    batch: dict[str, Any] = {
        schema.TASK: [TASKS[seed % len(TASKS)]],
    }
    for camera in schema.CAMERAS:
        for key in (schema.intrinsics_key(camera), schema.extrinsics_key(camera)):
            batch[key] = torch.from_numpy(frame[key])[None]
        colours, depth = frame[schema.image_key(camera)], frame[schema.depth_key(camera)]
        batch[schema.image_key(camera)] = torch.from_numpy(colours).permute(2, 0, 1)[None].float() / 255
        batch[schema.depth_key(camera)] = torch.from_numpy(depth.astype(np.float32)).permute(2, 0, 1)[None]
    steps = []
    for step in range(STEPS):
        state = frame[schema.STATE].copy()
        state[schema.POSITION] += 0.02 * (step // 2)
        steps.append(batch | {schema.STATE: torch.from_numpy(state)[None]})
    return steps


def _together(episodes: list[list[dict[str, Any]]], step: int) -> dict[str, Any]:
    rows = [episode[step] for episode in episodes]
    return {
        key: torch.cat([row[key] for row in rows]) if key != schema.TASK else [row[key][0] for row in rows]
        for key in rows[0]
    }


def _run(policy: LlakeyPolicy, episodes: list[list[dict[str, Any]]]) -> tuple[list[list[str]], torch.Tensor, list[int]]:
    policy.reset()
    said, actions = [], []
    for step in range(STEPS):
        actions.append(policy.select_action(_together(episodes, step)))
        said.append(policy.last_instructions)
    by_row = [list(row) for row in zip(*said, strict=True)]
    return by_row, torch.stack(actions, dim=1), [row.random_moves for row in policy.supervisors]


def test_a_batch_goes_as_its_rows_one_by_one(shipped: LlakeyPolicy) -> None:
    episodes = [_episode(seed) for seed in range(EPISODES)]
    said, actions, random_moves = _run(shipped, episodes)
    assert sum(random_moves) > EPISODES // 2  # they were put to the test
    for row in (5, 2, 0, 7, 1, 3, 6, 4):
        alone, by_itself, moves = _run(shipped, [episodes[row]])
        assert alone[0] == said[row]
        assert moves[0] == random_moves[row]
        assert torch.allclose(by_itself[0], actions[row], atol=TOLERANCE), row
