"""The continuous rotation: orthonormal columns, and a loss fit for it."""

import math

import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from lerobot_llakey import geometry
from lerobot_llakey.policies.action.heads.rotation_sixd import SixDHead, chordal_angle, orthonormal


def matrices(rotations: Rotation) -> Tensor:
    return torch.from_numpy(rotations.as_matrix()).float()


def test_any_two_columns_become_a_rotation() -> None:
    made = orthonormal(torch.randn(50, 3, 2, generator=torch.Generator().manual_seed(0)))
    assert torch.allclose(made @ made.transpose(1, 2), torch.eye(3).expand(50, 3, 3), atol=1e-5)
    assert torch.allclose(torch.linalg.det(made), torch.ones(50), atol=1e-5)


def test_a_rotations_own_columns_give_it_back_whatever_their_length() -> None:
    rotations = matrices(Rotation.random(20, random_state=0))
    assert torch.allclose(orthonormal(rotations[..., :2] * torch.tensor([3.0, 0.2])), rotations, atol=1e-5)


@pytest.mark.parametrize("degrees", [1.0, 5.0, 40.0, 120.0, 180.0])
def test_the_loss_is_the_chord_of_the_angle(degrees: float) -> None:
    rotation = Rotation.random(random_state=1)
    other = rotation * Rotation.from_rotvec([0, 0.6 * math.radians(degrees), 0.8 * math.radians(degrees)])
    loss = chordal_angle(matrices(rotation), matrices(other)).item()
    assert loss == pytest.approx(2 * math.sin(math.radians(degrees) / 2), abs=2e-4)


def test_the_slope_neither_vanishes_near_the_truth_nor_explodes_at_a_half_turn() -> None:
    slopes = []
    for degrees in (1.0, 20.0, 179.9):
        angle = torch.tensor(math.radians(degrees), requires_grad=True)
        cos, sin, zero = angle.cos(), angle.sin(), torch.zeros(())
        turned = torch.stack((cos, -sin, zero, sin, cos, zero, zero, zero, zero + 1)).view(3, 3)
        chordal_angle(turned, torch.eye(3)).backward()
        slopes.append(angle.grad.item())
    assert slopes == pytest.approx([1.0, math.cos(math.radians(10)), 0.0], abs=1e-2)


@pytest.mark.parametrize(("frames", "start"), [(("view", "hand"), geometry.top_down()), (("hand", "view"), None)])
def test_it_starts_near_one_clear_rotation(frames: tuple[str, ...], start: object) -> None:
    torch.manual_seed(0)
    head = SixDHead(8, 16, frames)
    torch.nn.init.zeros_(head.votes.weight)
    hand = torch.tensor([[0.4, 0.2, -0.1]])
    first = head.quaternion(head(torch.randn(1, 8), hand, torch.zeros(1)))
    second = head.quaternion(head(torch.randn(1, 8), hand, torch.zeros(1)))
    assert torch.equal(first, second) and first.isfinite().all()
