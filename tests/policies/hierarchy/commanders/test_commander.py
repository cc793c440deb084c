import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.commanders.commander import take_rows


def test_takes_rows_of_everything_that_has_rows() -> None:
    batch = {
        schema.STATE: torch.arange(45.0).reshape(3, 15),
        schema.TASK: ["a", "b", "c"],
        "scalar": torch.tensor(7.0),
        "shared": torch.zeros(2, 4),
        "info": None,
    }
    taken = take_rows(batch, [2, 0])
    assert torch.equal(taken[schema.STATE], batch[schema.STATE][[2, 0]])
    assert taken[schema.TASK] == ["c", "a"]
    assert taken["scalar"] is batch["scalar"] and taken["shared"] is batch["shared"] and taken["info"] is None
