import torch
from torch import nn

from lerobot_llakey.policies.command.small.numbers import spread_numbers


def test_neighbours_begin_alike_no_two_the_same_and_other_words_stay():
    torch.manual_seed(0)
    embedding = nn.Embedding(300, 64)
    before = embedding.weight.detach().clone()
    tokens = list(range(299, 43, -1))  # in the order of the numbers, not of the tokens
    spread_numbers(embedding, tokens)
    assert torch.equal(embedding.weight[:44], before[:44])
    curve = embedding.weight.detach()[tokens]
    distances = torch.cdist(curve, curve)
    off_diagonal = distances + torch.eye(len(tokens)) * 9
    assert off_diagonal.min() > 0.1 * distances.mean()
    assert distances.diagonal(1).mean() < 0.6 * distances.mean()
