"""The figures that the paper gives (table I), in percent. They are from another simulator and other task models."""

from __future__ import annotations

TASKS = (
    "move_block",
    "move_cup",
    "put_bulb",
    "stack_wine",
    "close_jar",
    "open_drawer",
    "put_groceries_in_cupboard",
    "light_bulb_in",
    "place_shape_in_shape_sorter",
)
"""Our names of the paper's columns, in its order."""
SIMULATOR = "CoppeliaSim"
FROM_THE_PAPER = f"the paper's, from {SIMULATOR}"
"""What stands beside a figure of the paper's."""

_SUCCESS: dict[str, tuple[float, ...]] = {
    "LLaKey 13B (3)": (96, 91, 98, 98, 78, 79, 33, 59, 51),
    "RVT": (84, 52, 52, 84, 42, 72, 64, 42, 52),
}
_SEQUENTIAL_PREDICTION: dict[str, tuple[float, ...]] = {
    "LLaVA 7B (3)": (90.1, 87.0, 86.6, 86.1, 88.1, 88.6, 70.2, 86.0, 78.2),
    "LLaVA 13B (3)": (94.6, 86.8, 88.4, 84.7, 91.1, 89.8, 71.6, 85.3, 77.3),
    "LLaVA 13B (1)": (67.4, 57.8, 66.8, 62.0, 66.6, 76.1, 32.9, 64.6, 34.7),
    "GPT-4V (3)": (3.8, 0, 0, 0, 0, 22.1, 0, 3.2, 2.3),
}
_ERROR_CORRECTION: dict[str, tuple[float, ...]] = {
    "LLaVA 7B (3)": (88.7, 90.5, 88.6, 86.1, 78.1, 90.1, 74.2, 82.0, 78.0),
    "LLaVA 13B (3)": (87.6, 92.6, 92.0, 86.7, 78.6, 87.8, 76.6, 88.3, 77.8),
    "LLaVA 13B (1)": (79.0, 64.1, 81.1, 69.4, 61.0, 83.0, 33.0, 53.1, 25.0),
    "GPT-4V (3)": (3.2, 0, 0, 0, 0, 21.0, 0, 3.0, 2.5),
}


def _by_task(rows: dict[str, tuple[float, ...]]) -> dict[str, dict[str, float]]:
    return {name: dict(zip(TASKS, figures, strict=True)) for name, figures in rows.items()}


SUCCESS = _by_task(_SUCCESS)
"""Success by row and task: table I, "multi-skill"."""
ABILITIES = {
    "sequential_prediction": _by_task(_SEQUENTIAL_PREDICTION),
    "error_correction": _by_task(_ERROR_CORRECTION),
}
"""By ability, model and task: table I, "comprehensive predictive capability"."""
