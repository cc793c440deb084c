"""What the page is told, and which corrections it may ask for."""

import json
from pathlib import Path
from typing import Any

import pytest

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.labelling import answers
from lerobot_llakey.labelling.session import LabelSession


@pytest.fixture
def session(found: list[FoundKeyframes], tmp_path: Path) -> LabelSession:
    return LabelSession(found, tmp_path / "a.csv", BASIC_GRAMMAR)


def test_an_episode_is_told_with_its_curves_and_keyframes(session: LabelSession) -> None:
    session.say(0, 10, "grasp the cup")
    told = json.loads(json.dumps(answers.episode(session, 0)))
    assert (told["frames"], told["fps"], told["task"], told["complete"]) == (40, 10.0, "lift the cup", False)
    assert len(told["opening"]) == len(told["speed"]) == 40
    assert told["keyframes"][:2] == [
        {"frame": 10, "text": "grasp the cup", "open": True, "valid": True},
        {"frame": 20, "text": "", "open": False, "valid": False},
    ]


def test_the_overview_tells_what_is_complete(session: LabelSession) -> None:
    for frame in (10, 20, 39):
        session.say(1, frame, "grasp the cup")
    told = answers.overview(session, ("front",), "me/r")
    assert [one["complete"] for one in told["episodes"]] == [False, True, False]
    assert told["cameras"] == ["front"] and told["repo_id"] == "me/r" and not told["free"]
    assert answers.keyframes(session, 0)["alike"] == 1


@pytest.mark.parametrize(
    ("wanted", "frames"),
    [
        ({"do": "move", "frame": 10, "to": 12}, [12, 20, 39]),
        ({"do": "add", "frame": 5}, [5, 10, 20, 39]),
        ({"do": "remove", "frame": 10}, [20, 39]),
        ({"do": "say", "frame": 10, "text": "a"}, [10, 20, 39]),
        ({"do": "fill", "source": 1}, [10, 20, 39]),
    ],
)
def test_a_correction_answers_with_the_keyframes_after_it(
    wanted: dict[str, Any], frames: list[int], session: LabelSession
) -> None:
    told = answers.correct(session, 0, wanted)
    assert [one["frame"] for one in told["keyframes"]] == frames and told["episode"] == 0


@pytest.mark.parametrize(
    "wanted",
    [
        {},
        {"do": "undo"},
        {"do": ["move"]},
        {"do": "move", "frame": 10},
        {"do": "move", "frame": "10", "to": 12},
        {"do": "move", "frame": True, "to": 12},
        {"do": "add", "frame": 1.5},
        {"do": "say", "frame": 10, "text": None},
        {"do": "add", "frame": 10**30},
    ],
)
def test_what_is_no_correction_is_refused(wanted: dict[str, Any], session: LabelSession) -> None:
    with pytest.raises(LlakeyError, match="Expected"):
        answers.correct(session, 0, wanted)
    assert not session.path.exists()
