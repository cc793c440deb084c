"""Records of steps, for tests of those who are told of them."""

from typing import Any

from lerobot_llakey.policies.hierarchy.step_log import Step


def a_step(row: int = 0, **changes: Any) -> Step:
    """A step of a row at the origin."""
    values: dict[str, Any] = {
        "row": row,
        "index": 0,
        "task": "close the red jar",
        "said": "grasp the lid",
        "instruction": "grasp the lid",
        "source": "policy",
        "likelihood": 0.9,
        "unparsable": False,
        "repeats": 0,
        "random_move": False,
        "moved": None,
        "state": (0.0,) * 6 + (1.0, 0.0),
        "proposed": (0.0,) * 6 + (1.0, 0.0, 0.0),
        "sent": (0.0,) * 6 + (1.0, 0.0, 0.0),
    }
    return Step(**values | changes)
