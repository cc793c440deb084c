import torch
from torch import nn

from lerobot_llakey.policies.action.parameter_groups import parameter_groups

SHAPES = {
    "text.first.weight": (100, 64),
    "fine.network.fine.0.spread.weight": (64, 64, 3, 3),
    "fine.network.head.linear.weight": (16, 64),
    "fine.network.fine.0.norm.weight": (64,),
}


def named(frozen: str = "") -> list[tuple[str, nn.Parameter]]:
    return [(name, nn.Parameter(torch.zeros(shape), name != frozen)) for name, shape in SHAPES.items()]


def shapes(group: dict) -> list[tuple[int, ...]]:
    return [tuple(value.shape) for value in group["params"]]


def test_hidden_kernels_go_to_muon_and_vectors_do_not_decay() -> None:
    weights, vectors, hidden = parameter_groups(named(), muon=True)
    assert shapes(weights) == [(100, 64), (16, 64)]
    assert shapes(vectors) == [(64,)] and vectors["weight_decay"] == 0.0
    assert shapes(hidden) == [(64, 64, 3, 3)] and hidden["muon"] is True


def test_without_muon_all_weights_are_one_group() -> None:
    weights, _ = parameter_groups(named(), muon=False)
    assert shapes(weights) == [(100, 64), (64, 64, 3, 3), (16, 64)]


def test_what_is_frozen_is_left_out() -> None:
    groups = parameter_groups(named(frozen="fine.network.fine.0.spread.weight"), muon=True)
    assert len(groups) == 2 and (64, 64, 3, 3) not in shapes(groups[0])
