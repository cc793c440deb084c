"""Instructions that need nobody to type them: a skill's file, and LeRobot's rows of style subtask."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from lerobot.annotations.steerable_pipeline.reader import iter_episodes
from lerobot.annotations.steerable_pipeline.staging import EpisodeStaging
from lerobot.annotations.steerable_pipeline.writer import LanguageColumnsWriter
from lerobot.datasets.language import language_feature_info
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.utils import INFO_PATH

from lerobot_llakey import schema
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.sequences import read_sequences
from lerobot_llakey.datasets.skill_instructions import from_sequences, from_subtasks
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import FREE, Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR

LONG = ["move to the top of the {thing}", "grasp the {thing}", "raise the robotic arm"]
SKILLS = {
    "take": {"descriptions": ["take the {thing}", "pick up the {thing}"], "sequences": [LONG[:2], LONG]},
    "put": {"descriptions": ["put it down"], "sequences": [["move to the top of the table", "release the cup"]]},
}


def episode(index: int, task: str, gripper: str, has_gripper: bool = True) -> FoundKeyframes:
    """One with a keyframe every ten frames; ``gripper`` has a letter for the first frame and one for each keyframe."""
    keyframes = [10 * number - 1 for number in range(1, len(gripper))]
    opened = np.repeat([letter == "o" for letter in gripper[1:]], 10)
    opened[0] = gripper[0] == "o"
    for frame, letter in zip(keyframes, gripper[1:], strict=True):
        opened[frame] = letter == "o"
    names = schema.HAND_NAMES if has_gripper else schema.POSE_NAMES
    return FoundKeyframes(index, task, np.zeros((len(opened), len(names))), names, opened, keyframes, 10)


def skills(folder: Path, content: Any = None, grammar: Grammar = BASIC_GRAMMAR) -> Any:
    path = folder / "skills.yaml"
    path.write_text(yaml.safe_dump(content or SKILLS))
    return read_sequences(path, grammar)


def test_a_sequence_is_chosen_by_the_number_of_keyframes_and_filled(tmp_path: Path) -> None:
    found = [
        episode(0, "take the cup", "ooc"),
        episode(1, "Pick up the red block", "oocc"),
        episode(4, "put it down", "cco"),
    ]
    spoken = from_sequences(found, skills(tmp_path))
    assert spoken == {
        0: ["move to the top of the cup", "grasp the cup"],
        1: ["move to the top of the red block", "grasp the red block", "raise the robotic arm"],
        4: ["move to the top of the table", "release the cup"],
    }


def test_without_a_gripper_and_with_free_text_the_number_alone_decides(tmp_path: Path) -> None:
    assert len(from_sequences([episode(0, "take the cup", "oooo", False)], skills(tmp_path))[0]) == 3
    free = {"wave": {"descriptions": ["wave"], "sequences": [["lift the flag"], ["lift the flag", "lower the flag"]]}}
    spoken = from_sequences([episode(0, "wave", "ooc")], skills(tmp_path, free, Grammar.load(FREE)))
    assert spoken == {0: ["lift the flag", "lower the flag"]}


def test_episodes_that_fit_nothing_are_said(tmp_path: Path) -> None:
    tasks = skills(tmp_path)
    with pytest.raises(LlakeyError, match=r"got 1 of 2 episodes that do not: oo in episode 3 \(take: oc or occ\); add"):
        from_sequences([episode(0, "take the cup", "ooc"), episode(3, "take the cup", "ooo")], tasks)
    with pytest.raises(
        LlakeyError, match=r"descriptions \('put it down'; 'take the \{thing\}', .*got 'fold it' in episode 2"
    ):
        from_sequences([episode(2, "fold it", "oo")], tasks)


def moving(root: Path) -> LeRobotDataset:
    """Two episodes of a hand that moves, rests, moves and rests, at 10 fps."""
    features: dict[str, Any] = {key: schema.vector(schema.POSE_NAMES) for key in (schema.STATE, schema.ACTION)}
    dataset = LeRobotDataset.create("me/moving", 10, features, root=root, use_videos=False)
    for _ in range(2):
        for frame in range(31):
            away = 0.02 * (min(frame, 10) + max(frame - 15, 0) - max(frame - 25, 0))
            pose = np.array([0.3 + away, 0, 0.3, 1, 0, 0, 0], dtype=np.float32)
            dataset.add_frame({schema.STATE: pose, schema.ACTION: pose, schema.TASK: "take the cup"})
        dataset.save_episode()
    dataset.finalize()
    return LeRobotDataset("me/moving", root=root)


def annotated_by_lerobot(folder: Path, rows: dict[int, list[dict[str, Any]]]) -> LeRobotDataset:
    """A recording into which LeRobot's own writer wrote persistent rows."""
    source = moving(folder / "source")
    records = list(iter_episodes(source.root))
    for record in records:
        EpisodeStaging(folder / "staging", record.episode_index).write("plan", rows[record.episode_index])
    LanguageColumnsWriter().write_all(records, folder / "staging", source.root)
    info = json.loads((path := source.root / INFO_PATH).read_text())
    info["features"] |= json.loads(json.dumps(language_feature_info()))
    path.write_text(json.dumps(info))
    return LeRobotDataset("me/moving", root=source.root)


def row(time: float, text: str, style: str = "subtask") -> dict[str, Any]:
    return {"role": "assistant", "content": text, "style": style, "timestamp": time, "camera": None}


def test_subtasks_are_taken_where_they_last_longest(tmp_path: Path) -> None:
    rows = {
        0: [row(0, "find a plan", "plan"), row(0, LONG[1].format(thing="cup")), row(1.4, LONG[2])],
        1: [row(0.3, LONG[2]), row(0.9, "grasp the cup"), row(2.9, "raise the robotic arm")],
    }
    source = annotated_by_lerobot(tmp_path, rows)
    found = find_keyframes(source)
    assert [one.keyframes for one in found] == [[10, 30]] * 2
    spoken = from_subtasks(source, found)
    assert spoken == {0: ["grasp the cup", "raise the robotic arm"], 1: ["raise the robotic arm", "grasp the cup"]}
    copy = annotate(source, found, spoken, tmp_path / "copy", "me/copy")
    assert [copy[index][schema.INSTRUCTION] for index in (0, 12, 31, 50)] == [*spoken[0], *spoken[1]]


def test_a_recording_or_an_episode_without_subtasks_is_said(tmp_path: Path) -> None:
    source = moving(tmp_path / "plain")
    with pytest.raises(LlakeyError, match=r"column language_persistent .* got none; write them with lerobot-annotate"):
        from_subtasks(source, find_keyframes(source))
    source = annotated_by_lerobot(tmp_path, {0: [row(0, "grasp the cup")], 1: [row(0, "first this", "plan")]})
    with pytest.raises(LlakeyError, match=r"style subtask in language_persistent of episode 1, got none"):
        from_subtasks(source, find_keyframes(source))
