import pytest
import torch

from lerobot_llakey.policies import muon
from lerobot_llakey.policies.muon import Muon, MuonConfig, orthogonalised


@pytest.mark.parametrize("shape", [(8, 8), (6, 9), (6, 20), (20, 6), (16, 144)])
def test_orthogonalised_keeps_singular_vectors_and_levels_the_values(shape):
    torch.manual_seed(0)
    matrix = torch.randn(shape)
    left, _, right = torch.linalg.svd(matrix, full_matrices=False)
    result = orthogonalised(matrix).float()
    assert result.shape == shape
    inner = left.T @ result @ right.T
    assert inner.diag().min() > 0.5 and inner.diag().max() < 1.4
    assert (inner - inner.diag().diag()).abs().max() < 0.1


def test_both_ways_to_orthogonalise_give_the_same(monkeypatch):
    torch.manual_seed(0)
    # Nearly singular, as gradients are.
    matrix = torch.randn(24, 96) @ torch.diag(torch.logspace(0, -6, 96))
    monkeypatch.setattr(muon, "_MUCH_WIDER", float("inf"))
    plain = orthogonalised(matrix)
    monkeypatch.setattr(muon, "_MUCH_WIDER", 0.0)
    torch.testing.assert_close(orthogonalised(matrix), plain, rtol=0.0, atol=1e-3)


def test_unmarked_groups_are_changed_as_by_adamw():
    torch.manual_seed(0)
    ours, theirs = (torch.nn.Parameter(torch.ones(3, 4)) for _ in range(2))
    matrix = torch.nn.Parameter(torch.ones(3, 4))
    optimizer = Muon([{"params": [ours]}, {"params": [matrix], "muon": True}], lr=0.1, weight_decay=0.01)
    reference = torch.optim.AdamW([theirs], lr=0.1, weight_decay=0.01)
    for _ in range(3):
        gradient = torch.randn(3, 4)
        ours.grad, theirs.grad, matrix.grad = gradient, gradient.clone(), gradient.clone()
        optimizer.step()
        reference.step()
    assert torch.allclose(ours, theirs, atol=1e-6)
    assert not torch.allclose(matrix, ours, atol=1e-3)


@pytest.mark.parametrize("shape", [(12, 12), (6, 20), (20, 6)])
def test_marked_matrices_are_changed_as_by_pytorchs_muon(shape):
    torch.manual_seed(0)
    start, settings = torch.randn(shape), {"lr": 0.05, "weight_decay": 0.02, "momentum": 0.9}
    ours, theirs = torch.nn.Parameter(start.clone()), torch.nn.Parameter(start.clone())
    optimizer = Muon([{"params": [ours], "muon": True}], **settings)
    reference = torch.optim.Muon([theirs], adjust_lr_fn="match_rms_adamw", **settings)
    for _ in range(4):
        gradient = torch.randn(shape)
        ours.grad, theirs.grad = gradient, gradient.clone()
        optimizer.step()
        reference.step()
    # Theirs computes in bfloat16, of three digits, wherever it runs.
    assert (ours - theirs).norm() < 0.03 * (theirs - start).norm()


def test_it_learns_a_linear_map_and_goes_on_after_a_restart():
    torch.manual_seed(0)
    wanted, inputs = torch.randn(6, 5), torch.randn(64, 5)
    weight = torch.nn.Parameter(torch.zeros(6, 5))

    def train(optimizer: Muon, steps: int) -> float:
        for _ in range(steps):
            optimizer.zero_grad()
            loss = ((inputs @ (weight - wanted).T) ** 2).mean()
            loss.backward()
            optimizer.step()
        return loss.item()

    groups = [{"params": [weight], "muon": True}]
    config = MuonConfig(lr=0.05, weight_decay=0.0)
    first = config.build(groups)
    early = train(first, 10)
    second = config.build([{"params": [weight], "muon": True}])
    second.load_state_dict(first.state_dict())
    assert second.state[weight]["momentum"].equal(first.state[weight]["momentum"])
    assert train(second, 150) < 0.05 * early


def test_only_matrices_may_be_marked():
    with pytest.raises(ValueError, match=r"Expected matrices .* got \{\(3,\)\}"):
        MuonConfig().build([{"params": [torch.nn.Parameter(torch.zeros(3))], "muon": True}])
