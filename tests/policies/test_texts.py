import pytest

from lerobot_llakey.policies.texts import text_column


def test_one_text_a_row_whatever_the_column_holds():
    assert text_column({"task": "grasp"}, "task") == ["grasp"]
    assert text_column({"task": ("a", "b")}, "task") == ["a", "b"]
    assert text_column({}, "task", default=["", ""]) == ["", ""]


def test_a_missing_column_is_named():
    with pytest.raises(ValueError, match=r"Expected 'task' in the batch, got \['other'\]"):
        text_column({"other": 1}, "task")
