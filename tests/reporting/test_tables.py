"""Columns line up."""

from lerobot_llakey.reporting.tables import markdown_table


def test_columns_line_up() -> None:
    lines = markdown_table(["name", "value"], [["a", "1"], ["longer name", "22"]]).splitlines()
    assert len({len(line) for line in lines}) == 1
    assert lines[1].startswith("|--")
