"""Sequences of instructions by task, filled from the skill instruction and chosen by the gripper."""

from pathlib import Path

import pytest
import yaml

from lerobot_llakey.datasets.sequences import SHIPPED, read_sequences, shown
from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.sim.tasks import make_task

SHARED = ("open_drawer", "close_jar", "light_bulb_in", "put_groceries_in_cupboard", "place_shape_in_shape_sorter")
TASKS = read_sequences(SHIPPED, BASIC_GRAMMAR)


def opened(letters: str) -> list[bool]:
    return [letter == "o" for letter in letters]


def test_the_shared_tasks_have_instructions() -> None:
    assert set(TASKS) == set(SHARED)
    for task in SHARED:
        assert make_task(task).name == task


@pytest.mark.parametrize(
    ("task", "skill", "letters", "last"),
    [
        ("open_drawer", "open the bottom drawer", "occ", "pull the bottom drawer open"),
        ("close_jar", "close the red jar", "occcco", "release the lid"),
        ("close_jar", "screw on the azure jar lid", "occccco", "release the lid"),
        ("light_bulb_in", "Screw in the  rose light bulb", "occccco", "release the rose light bulb"),
        (
            "put_groceries_in_cupboard",
            "put the chocolate jello in the cupboard",
            "occco",
            "move to the top of the shelf and release the chocolate jello",
        ),
        (
            "place_shape_in_shape_sorter",
            "slot the triangular prism into the shape sorter",
            "occcc",
            "insert the triangular prism into the shape sorter",
        ),
    ],
)
def test_a_sequence_is_chosen_and_filled(task: str, skill: str, letters: str, last: str) -> None:
    found = TASKS[task].fitting(["something else", skill], opened(letters))
    assert found is not None and found[1][-1] == last and len(found[1]) == len(letters)
    assert all(BASIC_GRAMMAR.is_parsable(text) for text in found[1])


def test_a_gripper_that_does_other_things_fits_nothing() -> None:
    assert TASKS["open_drawer"].fitting(["open the top drawer"], opened("ococ")) is None
    assert TASKS["open_drawer"].fitting(["open the top drawer"], opened("oco")) is None
    assert TASKS["open_drawer"].patterns() == "occ" and shown([True, False]) == "oc"


def test_a_slot_that_comes_twice_takes_the_same_words() -> None:
    drawer = TASKS["open_drawer"]
    assert drawer.variables(["grip the top handle and pull the top drawer open"]) == {"drawer": "top"}
    with pytest.raises(LlakeyError, match="add its form to the descriptions"):
        drawer.variables(["grip the top handle and pull the bottom drawer open"])


@pytest.mark.parametrize(
    ("content", "match"),
    [
        ([], "tasks with descriptions and sequences"),
        ({"a": {"descriptions": ["x"]}}, "descriptions and sequences of a "),
        ({"a": {"descriptions": ["x"], "sequences": [[]]}}, "descriptions and sequences of a "),
        ({"a": {"descriptions": ["x {b}", "x"], "sequences": [["grasp the {b} cup"]]}}, "Expected b in each .*got 'x'"),
        ({"a": {"descriptions": ["x {b}"], "sequences": [["seize the {b} cup"]]}}, "basic action"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, content: object, match: str) -> None:
    path = tmp_path / "some.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(LlakeyError, match=match):
        read_sequences(path, BASIC_GRAMMAR)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"none\.yaml"):
        read_sequences(tmp_path / "none.yaml", BASIC_GRAMMAR)
