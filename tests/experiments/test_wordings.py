"""The wordings of figure 1, on the simulator's own skill instructions."""

import pytest

from lerobot_llakey.experiments import wordings
from lerobot_llakey.experiments.wordings import PAPER, TESTS, TRAININGS, reword, trained_wording
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED

RED, BLUE = "put the red light bulb in the purple box", "put the blue light bulb in the orange box"


def test_one_wording_is_the_simulators_for_both_sequences() -> None:
    assert trained_wording("one", RED, SCREWED) == RED
    assert trained_wording("one", BLUE, LOOSE) == BLUE


def test_two_wordings_name_the_unscrewing() -> None:
    assert trained_wording("two", RED, SCREWED) == "unscrew the red light bulb and put it into the purple box"
    assert trained_wording("two", BLUE, LOOSE) == BLUE


@pytest.mark.parametrize("training", TRAININGS)
def test_swapped_verbs_are_those_of_the_other_sequence(training: str) -> None:
    assert wordings.TestedWording(training, "swapped")(RED, SCREWED) == RED
    swapped = wordings.TestedWording(training, "swapped")(BLUE, LOOSE)
    assert swapped == "unscrew the blue light bulb and put it into the orange box"


@pytest.mark.parametrize(("training", "sequence"), [("one", SCREWED), ("two", LOOSE)])
def test_the_papers_own_changes(training: str, sequence: int) -> None:
    assert wordings.TestedWording(training, "removed")(RED, sequence) == "red light bulb, purple box"
    assert (
        wordings.TestedWording(training, "replaced")(RED, sequence)
        == "take the red light bulb and it into the purple box"
    )


def test_another_tasks_instruction_is_refused() -> None:
    with pytest.raises(ValueError, match="use put_bulb"):
        reword("open the top drawer", "{bulb}")


def test_the_papers_figures_are_of_arms_that_there_are() -> None:
    assert all(training in TRAININGS and test in TESTS for training, test in PAPER)
    assert PAPER["two", "replaced"] - PAPER["two", "as_trained"] == 12
