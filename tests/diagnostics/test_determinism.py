"""The same episode gives the same digest, another one does not."""

import numpy as np
import pytest

from lerobot_llakey.diagnostics.determinism import WAYS, determinism, digest_alone, expert_actions


@pytest.mark.slow
def test_a_seed_gives_the_same_pictures_everywhere() -> None:
    digests = determinism(["move_cup"])["move_cup"]
    assert tuple(digests) == WAYS and len(set(digests.values())) == 1


def test_other_seeds_and_actions_give_other_digests() -> None:
    actions, digest = expert_actions("move_block", 0, "val")
    other = np.array(actions)
    other[-1, 2] += 0.001
    found = {digest_alone("move_block", seed, "val", moved) for seed, moved in ((1, actions), (0, other))}
    assert len(found) == 2 and digest not in found
