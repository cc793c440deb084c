import pytest
import torch

from lerobot_llakey.policies.command.decoding.choice import GREEDY, Choice


def test_the_first_of_the_most_probable_is_taken():
    assert GREEDY.pick(torch.tensor([0.0, 2.0, 2.0])) == 1


def test_a_low_temperature_draws_the_most_probable_and_a_high_one_draws_all():
    torch.manual_seed(0)
    scores = torch.tensor([0.0, 1.0, 2.0])
    assert {Choice(True, 0.01).pick(scores) for _ in range(50)} == {2}
    assert {Choice(True, 10.0).pick(scores) for _ in range(50)} == {0, 1, 2}


@pytest.mark.parametrize("temperature", [0.0, -1.0, float("nan")])
def test_temperatures_without_meaning_are_refused(temperature):
    with pytest.raises(ValueError, match="temperature above 0"):
        Choice(True, temperature)
