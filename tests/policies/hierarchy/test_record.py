import json

from fakes_steps import a_step
from lerobot_llakey import schema


def test_a_step_can_be_written_down() -> None:
    read = json.loads(json.dumps(a_step(3, likelihood=None, moved=True).as_json()))
    assert (read["row"], read["likelihood"], read["moved"], len(read["state"]), len(read["sent"])) == (
        3,
        None,
        True,
        schema.HAND_DIM,
        schema.ACTION_DIM,
    )
