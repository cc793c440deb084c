"""Angles one after another: each knows those before it."""

import torch
from torch import Tensor

from lerobot_llakey import geometry
from lerobot_llakey.policies.action.heads.rotation_sequential import SequentialBinsHead
from lerobot_llakey.policies.action.heads.targets import angles_to_quaternion, bin_angles

ABOUT_Z, ABOUT_Y, ABOUT_X = 0, 1, 2


def make_head() -> SequentialBinsHead:
    torch.manual_seed(0)
    return SequentialBinsHead(10, 72, 32, ("view",))


def truth(*bins: int) -> Tensor:
    return angles_to_quaternion(bin_angles(torch.tensor([bins]), 72))


def logits(head: SequentialBinsHead, true: Tensor | None) -> Tensor:
    features = torch.linspace(-1.0, 1.0, 10)[None]
    return head(features, torch.zeros(1, 3), torch.zeros(1), true).rotation[0]


def test_later_angles_know_the_earlier_true_ones_and_no_others() -> None:
    head = make_head()
    plain = logits(head, truth(3, 2, 5))
    for axis, changed in ((ABOUT_X, {ABOUT_Y, ABOUT_Z}), (ABOUT_Y, {ABOUT_Z}), (ABOUT_Z, set())):
        bins = [3, 2, 5]
        bins[axis] += 9
        other = logits(head, truth(*bins))
        assert {place for place in range(3) if not torch.allclose(plain[place], other[place])} == changed


def test_predicting_feeds_back_the_likeliest_bins() -> None:
    head = make_head()
    free = logits(head, None)
    chosen = free.argmax(dim=-1)
    # The second angle's bins reach only a half turn: keep the choice within it, or two sets of angles are one rotation.
    head.votes[1][-1].bias.data[chosen[ABOUT_Y]] -= 100.0
    head.votes[1][-1].bias.data[4] += 100.0
    free = logits(head, None)
    taught = logits(head, truth(*free.argmax(dim=-1).tolist()))
    assert torch.allclose(free, taught, atol=1e-5)


def test_one_of_two_fitting_rotations_is_chosen_whole() -> None:
    # Half of the demonstrations grasp one way round and half the other: angles apart would mix them.
    head = SequentialBinsHead(4, 72, 32, ("view",))
    ways = torch.cat((truth(0, 0, 0), truth(18, 4, 9)))
    features = torch.ones(2, 4)
    optimiser = torch.optim.Adam(head.parameters(), lr=1e-2)
    for _ in range(150):
        output = head(features, torch.zeros(2, 3), torch.zeros(2), ways)
        optimiser.zero_grad()
        head.rotation_loss(output, ways).mean().backward()
        optimiser.step()
    chosen = head.quaternion(head(features[:1], torch.zeros(1, 3), torch.zeros(1)))
    assert (geometry.quaternion_to_matrix(chosen) - geometry.quaternion_to_matrix(ways)).abs().amax((1, 2)).min() < 1e-3
