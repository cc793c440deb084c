import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.episode_key import episode_key


def _batch() -> dict:
    return {
        schema.STATE: torch.arange(30.0).reshape(2, 15),
        schema.TASK: ["open the drawer", "close the jar"],
        schema.image_key("front"): torch.linspace(0, 1, 2 * 3 * 4 * 4).reshape(2, 3, 4, 4),
    }


def _turned() -> dict:
    return {key: value.flip(0) if isinstance(value, torch.Tensor) else value[::-1] for key, value in _batch().items()}


def test_does_not_depend_on_the_place_in_the_batch() -> None:
    assert episode_key(_batch(), 0) == episode_key(_turned(), 1) != episode_key(_batch(), 1)
    assert 0 <= episode_key(_batch(), 0) < 2**64


def test_depends_on_goal_state_and_pictures() -> None:
    keys = {episode_key(_batch(), 0)}
    for key in (schema.STATE, schema.image_key("front")):
        batch = _batch()
        batch[key].view(-1)[3] += 0.01
        keys.add(episode_key(batch, 0))
    keys.add(episode_key(_batch() | {schema.TASK: "open the door"}, 0))
    assert len(keys) == 4
