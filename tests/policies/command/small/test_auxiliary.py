import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.command.small.auxiliary import UNIT_METRES, KeyframeHead


def test_a_right_guess_costs_nothing_and_each_row_counts_apart():
    head = KeyframeHead(8)
    torch.nn.init.eye_(head.linear.weight)
    torch.nn.init.zeros_(head.linear.bias)
    state, action = torch.rand(2, schema.HAND_DIM), torch.rand(2, schema.ACTION_DIM)
    hidden = torch.cat((state[:, :3] / UNIT_METRES, state[:, 7:8], action[:, :3] / UNIT_METRES, action[:, 7:8]), dim=1)
    assert torch.allclose(head.loss(hidden, state, action), torch.zeros(2))
    hidden[1, 0] += 1.0
    loss = head.loss(hidden, state, action)
    assert loss[0] == 0 and loss[1] > 0


def test_it_can_be_learned():
    torch.manual_seed(0)
    head = KeyframeHead(16)
    hidden, state, action = torch.randn(4, 16), torch.rand(4, schema.HAND_DIM), torch.rand(4, schema.ACTION_DIM)
    optimizer = torch.optim.Adam(head.parameters(), lr=0.1)
    first = head.loss(hidden, state, action).mean()
    for _ in range(100):
        optimizer.zero_grad()
        loss = head.loss(hidden, state, action).mean()
        loss.backward()
        optimizer.step()
    assert loss < 0.1 * first
