"""Rows are read from a file or from paths, and what is wrong with them is told in a sentence."""

from pathlib import Path

import pytest

from lerobot_llakey.evaluation.protocol.rows import Row, read_rows


def test_rows_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "rows.yaml"
    file.write_text(
        "- {name: 'LLaKey (1 view)', command_path: a/b/c, action_path: d/e/f, views: [front]}\n"
        "- name: oracle\n  policy_path: x\n  overrides: {commander: oracle, command.constrain: false}\n"
    )
    first, second = read_rows(str(file))
    assert first == Row("LLaKey (1 view)", command_path="a/b/c", action_path="d/e/f", views=("front",))
    assert first.slug == "llakey__1_view" and first.paths == ["a/b/c", "d/e/f"]
    assert second.overrides == {"commander": "oracle", "command.constrain": False}


def test_rows_of_paths() -> None:
    rows = read_rows("checkpoints/llakey_small, outputs/act/checkpoints/last/pretrained_model,expert")
    assert [row.name for row in rows] == ["llakey_small", "act", "expert"]
    assert rows[1].paths == ["outputs/act/checkpoints/last/pretrained_model"] and rows[2].paths == []


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("name: x", "a list of rows"),
        ("- {name: x}", "policy_path or an action_path"),
        ("- {name: x, policy_paht: y}", "fields out of"),
        ("- {policy_path: y}", "a name"),
        ("- {name: x, policy_path: y}\n- {name: X, policy_path: y}", "a name of its own"),
        ("- {name: x", "readable YAML file of rows"),
        ("- {name: x, policy_path: 5}", "Expected text as policy_path"),
        ("- {name: x, policy_path: y, overrides: [1]}", "overrides as a mapping"),
        ("[]", "at least one row"),
    ],
)
def test_what_is_no_row_is_told(tmp_path: Path, content: str, words: str) -> None:
    file = tmp_path / "rows.yaml"
    file.write_text(content)
    with pytest.raises(ValueError, match=words):
        read_rows(str(file))


def test_a_missing_file_is_told() -> None:
    with pytest.raises(FileNotFoundError, match=r"nothing\.yaml"):
        read_rows("nothing.yaml")
