import pytest

from lerobot_llakey.grammar_data import LONGEST
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.chat import answers
from lerobot_llakey.policies.command.chat.answers import first_instruction


@pytest.mark.parametrize(
    "written",
    [
        "grasp the red block",
        "grasp the red block <next goal> release the red block",
        '"grasp the red block."',
        '"grasp the red block".',
        "**grasp the red block**",
        "\n\n- `grasp the red block`\n- release the red block",
        "1. grasp the red block\n2. raise the robotic arm",
        "Answer: grasp the red block",
        "**Next action:** \u201cgrasp the red block\u201d",
        "Sure! The next action is:\n\n**grasp the red block**\nGood luck!",
        "```\ngrasp the red block\n```",
        "<think>release the red block?\nno</think>\ngrasp the red block",
    ],
)
def test_the_first_basic_action_is_found(written):
    assert first_instruction(written, BASIC_GRAMMAR) == "grasp the red block"


@pytest.mark.parametrize(
    ("written", "left"),
    [
        ("I cannot tell.\nSorry.", "I cannot tell"),
        ("", ""),
        (" \n<next goal>grasp the red block", ""),
        ("<think>grasp the red block", ""),
        ("```", ""),
        ("open the drawer and then grasp the red block", "open the drawer and then grasp the red block"),
    ],
)
def test_other_words_stay_as_they_are(written, left):
    assert first_instruction(written, BASIC_GRAMMAR) == left
    assert not BASIC_GRAMMAR.is_parsable(left)


@pytest.mark.parametrize("written", ["1. " * 400_000, "rotate the " + "a to the " * 50_000, "1. " * 99 + "\n" * 9999])
def test_of_a_long_answer_a_short_line_is_left(written, monkeypatch):
    looked_at = []
    monkeypatch.setattr(answers, "_bare", lambda line: looked_at.append(line) or line)
    assert len(first_instruction(written, BASIC_GRAMMAR)) <= 2 * LONGEST
    assert len(looked_at) == 1 and len(looked_at[0]) <= 2 * LONGEST


def test_of_many_lines_the_first_are_looked_at(monkeypatch):
    looked_at = []
    monkeypatch.setattr(answers, "_bare", lambda line: looked_at.append(line) or line)
    assert first_instruction("hm\n" * 100_000 + "grasp the red block", BASIC_GRAMMAR) == "hm"
    assert len(looked_at) == 200
