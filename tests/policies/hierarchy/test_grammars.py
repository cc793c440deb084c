"""Own templates and free text: trained on, saved, loaded and carried out, through both parts."""

from pathlib import Path

import pyarrow as pa
import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.datasets.dataset_tools import delete_episodes, merge_datasets, remove_feature
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.datasets.rewrite import rewrite
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar, of_features
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy
from policies.hierarchy.conftest import tiny_config

OWN = {
    "templates": {
        "press": {"wordings": ["press {thing}", "push {thing} down"], "gripper": "closed"},
        "pour": {"wordings": ["pour {held} into {target}"]},
    }
}
TEXTS = {
    "own": {"move": "pour the milk into the cup", "grasp": "press the button"},
    "free": {"move": "Pour some milk, please", "grasp": "now ring!"},
}
GRAMMARS = {"own": OWN, "free": "free"}


def _worded(root: Path, texts: str, grammar: object = "basic") -> LeRobotDataset:
    """A tiny dataset with other texts and a grammar."""
    fake_keysteps(root, episodes=2, image_size=32)

    def of(table: pa.Table) -> dict[str, pa.Array]:
        columns = {key: table[key].to_pylist() for key in schema.TEXTS}
        return {
            key: pa.array([TEXTS[texts][text.split()[0]] if text else "" for text in column], type=pa.string())
            for key, column in columns.items()
        }

    features = schema.label_features(grammar)
    rewrite(root, of, {key: features[key] for key in schema.TEXTS})
    return LeRobotDataset("me/words", root=root)


@pytest.mark.parametrize("kind", ["own", "free"])
def test_trains_saves_loads_and_steps(kind: str, tmp_path: Path) -> None:
    dataset = _worded(tmp_path / "data", kind, GRAMMARS[kind])
    torch.manual_seed(0)
    policy = make_policy(tiny_config(), ds_meta=dataset.meta)
    assert isinstance(policy, LlakeyPolicy)
    batch = next(iter(torch.utils.data.DataLoader(dataset, batch_size=4)))
    optimizer = torch.optim.AdamW(policy.parameters(), lr=1e-3)
    for _ in range(3):
        loss, _ = policy.train().forward(batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    policy.save_pretrained(tmp_path / "checkpoint")
    loaded = LlakeyPolicy.from_pretrained(tmp_path / "checkpoint")
    config = loaded.config
    assert config.grammar == config.action.grammar == config.command.grammar == GRAMMARS[kind]
    hidden = (schema.INSTRUCTION, schema.PREVIOUS_INSTRUCTION, schema.ACTION)
    observation = {key: value for key, value in batch.items() if key not in hidden}
    for _ in range(2):
        assert loaded.select_action(observation).shape == (4, schema.ACTION_DIM)
    # The small model's vocabulary is in lower case.
    assert set(loaded.last_instructions) <= {text.lower() for text in TEXTS[kind].values()}
    assert not any(step.unparsable for row in loaded.log for step in row)


@pytest.mark.parametrize("make", [LlakeyCommandConfig, LlakeyActionConfig, LlakeyConfig])
def test_a_config_holds_the_whole_grammar(make: type, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("templates: {press: {wordings: ['press {thing}']}}")
    config = make(device="cpu", grammar=str(tmp_path / "mine.yaml"))
    (tmp_path / "mine.yaml").unlink()
    config._save_pretrained(tmp_path)
    assert PreTrainedConfig.from_pretrained(tmp_path).grammar == {
        "templates": {"press": {"wordings": ["press {thing}"]}}
    }
    if make is not LlakeyConfig:  # whose parts hold the other one
        assert PreTrainedConfig.from_pretrained(tmp_path, cli_overrides=["--grammar=free"]).rules.is_free


def test_texts_outside_the_grammar_and_two_grammars_are_refused(tmp_path: Path) -> None:
    unnamed = _worded(tmp_path / "unnamed", "free")
    with pytest.raises(LlakeyError, match="--grammar=free"):
        make_policy(tiny_config(), ds_meta=unnamed.meta)
    own = _worded(tmp_path / "own", "own", OWN)
    with pytest.raises(LlakeyError, match=r"one grammar in --policy.grammar and the dataset"):
        make_policy(tiny_config(grammar="free"), ds_meta=own.meta)
    with pytest.raises(LlakeyError, match="one grammar in the policy and its parts"):
        LlakeyConfig(
            command=LlakeyCommandConfig(device="cpu", grammar="free"),
            action=LlakeyActionConfig(device="cpu", grammar="basic"),
            device="cpu",
        )


def test_lerobots_tools_keep_the_grammar(tmp_path: Path) -> None:
    own = _worded(tmp_path / "own", "own", OWN)
    free = _worded(tmp_path / "free", "free", "free")
    shorter = delete_episodes(own, [0], output_dir=tmp_path / "shorter", repo_id="me/shorter")
    fewer = remove_feature(own, schema.STEP, output_dir=tmp_path / "fewer", repo_id="me/fewer")
    both = merge_datasets([shorter, own], "me/both", tmp_path / "both")
    for dataset in (shorter, fewer, both):
        assert of_features(dataset.meta.features, schema.INSTRUCTION) == Grammar.from_data(OWN)
    with pytest.raises(ValueError):
        merge_datasets([own, free], "me/mixed", tmp_path / "mixed")
