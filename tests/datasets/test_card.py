"""The dataset card: what it says of the simulator's datasets and of anyone's, in a form that the Hub reads."""

from pathlib import Path

import pytest
from huggingface_hub import DatasetCard
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_recordings import fake_demonstrations
from lerobot_llakey import schema
from lerobot_llakey.datasets import card
from lerobot_llakey.datasets.card_facts import read_facts
from lerobot_llakey.datasets.plan import Targets
from lerobot_llakey.errors import LlakeyError


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    """An annotated recording of another arm, with two cameras of its own."""
    return fake_demonstrations(tmp_path_factory.mktemp("foreign"), "five_joints", scale=0.125)


def parsed(made: DatasetCard) -> DatasetCard:
    """What the Hub's parser reads of a card."""
    text = str(made)
    assert "{{" not in text and "{%" not in text and "\n\n\n" not in text
    return DatasetCard(text)


def test_the_card_of_demonstrations_tells_all_of_them(collected: Targets) -> None:
    dataset = LeRobotDataset("me/demonstrations", root=collected.demonstrations)
    made = parsed(card.make_card(dataset, license="apache-2.0"))
    assert made.data.license == "apache-2.0" and {"LeRobot", "llakey"} <= set(made.data.tags)
    assert made.data.configs == [{"config_name": "default", "data_files": "data/*/*.parquet"}]
    text = made.text
    assert "# me/demonstrations" in text and "| licence | apache-2.0 |" in text
    assert f"| frames | {len(dataset)} |" in text and "| episodes | 3 |" in text
    assert "| simulated tasks | open_drawer (3) |" in text and "| origin | simulated |" in text
    last = max(dataset.hf_dataset.with_format(None)[schema.EPISODE_SEED])
    assert f"| scene seeds, split val | 100000000 to {last} (3 episodes) |" in text
    for key in schema.dataset_features():
        assert f"| `{key}` |" in text
    for task in dataset.meta.tasks.index:
        assert f"- {task} (1 episodes)\n" in text
    assert "| `wrist` | 32 x 32 | yes | moves |" in text and "| `front` | 32 x 32 | yes | stands still |" in text
    assert "llakey keysteps --repo_id=me/demonstrations" in text and dataset.meta.info.codebase_version in text


def test_the_counts_are_those_of_the_columns(collected: Targets) -> None:
    dataset = LeRobotDataset("me/demonstrations", root=collected.demonstrations)
    facts, rows = read_facts(dataset), dataset.hf_dataset.with_format(None)
    keyframes = [
        sum(rows[schema.IS_KEYFRAME][e["dataset_from_index"] : e["dataset_to_index"]]) for e in dataset.meta.episodes
    ]
    assert facts.keyframes == (min(keyframes), pytest.approx(sum(keyframes) / 3), max(keyframes))
    assert sum(frames for _, _, frames in facts.instructions) == len(dataset)
    assert sum(segments for _, segments, _ in facts.instructions) == sum(keyframes)
    assert sum(count for _, count in facts.sequences) == 3 and facts.simulated and facts.dense
    assert f"| {rows[schema.INSTRUCTION][0]} |" in card.make_card(dataset, facts).text


def test_the_card_of_keysteps_says_so(collected: Targets) -> None:
    dataset = LeRobotDataset("me/keysteps", root=collected.keysteps)
    text = parsed(card.make_card(dataset)).text
    assert "(*keysteps*)" in text and f"| samples | {len(dataset)} |" in text
    assert "--dataset.repo_id=me/keysteps" in text


def test_a_recording_from_elsewhere_has_no_seeds_and_no_licence(foreign: LeRobotDataset) -> None:
    facts, made = read_facts(foreign), parsed(card.make_card(foreign))
    assert not facts.simulated and facts.seeds == facts.simulated_tasks == [] and facts.dense
    assert made.data.license is None and "| licence | not given |" in made.text
    assert "| scene seeds | none: recordings |" in made.text and "| origin | recorded |" in made.text
    assert "| robot | five_joints |" in made.text and "| keyframes an episode | 3 to 3, 3.0 on average |" in made.text
    for camera in schema.cameras_of(foreign.features):
        height, width = foreign.features[schema.image_key(camera)]["shape"][:2]
        assert f"| `{camera}` | {height} x {width} | yes |" in made.text
    assert " → raise the robotic arm (1 episodes)" in made.text


def test_texts_break_no_table(foreign: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    facts = read_facts(foreign)
    object.__setattr__(facts, "instructions", [("press | the <b>red</b>\nbutton", 1, 2), ("", 1, 1)])
    text = card.make_card(foreign, facts).text
    assert "| press \\| the &lt;b>red&lt;/b> button | 1 | 2 |" in text and "| (empty) | 1 | 1 |" in text


def test_own_grammars_are_shown(foreign: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    info = foreign.meta.features[schema.INSTRUCTION]["info"]
    monkeypatch.setitem(info, "grammar", {"templates": {"press": {"wordings": ["press {thing}"]}}})
    assert (
        "own grammar, which stands in the instruction column's `info`: `press {thing}`." in card.make_card(foreign).text
    )
    monkeypatch.setitem(info, "grammar", "free")
    assert "Any sentence is an instruction here." in card.make_card(foreign).text


def test_a_dataset_without_instructions_has_to_be_annotated(foreign: LeRobotDataset) -> None:
    plain = LeRobotDataset("me/five_joints", root=Path(foreign.root).parent / "recording")
    with pytest.raises(LlakeyError, match="Expected demonstrations or keysteps with instruction, got me/five_joints"):
        card.make_card(plain)
