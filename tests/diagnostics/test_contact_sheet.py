"""The page of all tasks."""

import numpy as np

from lerobot_llakey.diagnostics.contact_sheet import contact_sheet


def test_the_page_has_a_row_a_task_and_shows_what_happened() -> None:
    before, after = (contact_sheet(["open_drawer", "move_block"], 0, actions, detailed=False) for actions in (0, 2))
    assert before.shape == after.shape == (2 * 192, 256 + 4 * 192, 3) and before.dtype == np.uint8
    for row in (slice(0, 192), slice(192, 384)):
        assert (np.abs(before[row].astype(int) - after[row]) > 8).mean() > 0.01
