import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from huggingface_hub import HfApi, ModelCard
from lerobot.configs import PreTrainedConfig
from lerobot.configs.default import DatasetConfig
from lerobot.configs.train import TrainPipelineConfig

from lerobot_llakey.policies.hierarchy.model_card import TrainingRun, make_model_card
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

TABLE = "| task | success |\n|---|---|\n| `close_jar` | 96 % |"


def test_a_card_says_what_each_kind_is_and_how_it_is_used(make_tiny) -> None:
    whole = make_tiny().config
    paths = {"path": whole, "command_path": whole.command, "action_path": whole.action}
    for option, config in paths.items():
        card = ModelCard(str(make_model_card(config, "me/it", TrainingRun("local/mine", 10, 2, 0))))
        assert (
            f"--policy.{option}=me/it" in card.text
            and "No evaluation results are known." in card.text
            and "{{" not in card.text
        )
        assert card.data.tags == ["LeRobot", "llakey", "robotics", *([config.type] if config.type != "llakey" else [])]
        assert card.data.datasets is None and "| trained on | local/mine |" in card.text
    assert "| cameras of the action policy | `front`" in str(make_model_card(whole, "me/it"))


@pytest.fixture
def uploaded(monkeypatch, tmp_path: Path) -> Path:
    """Where what would be uploaded ends up; nothing goes over the network."""
    target = tmp_path / "uploaded"

    def upload_folder(self, *, repo_id: str, folder_path: Path, **_) -> SimpleNamespace:
        assert repo_id == "someone/llakey"
        shutil.copytree(folder_path, target)
        return SimpleNamespace(repo_url=SimpleNamespace(url="https://huggingface.co/someone/llakey"))

    monkeypatch.setattr(HfApi, "create_repo", lambda self, repo_id, **_: SimpleNamespace(repo_id=repo_id))
    monkeypatch.setattr(HfApi, "upload_folder", upload_folder)
    return target


def _card(folder: Path) -> ModelCard:
    return ModelCard.load(folder / "README.md")


def test_a_pushed_policy_has_its_card_its_table_and_its_processors(saved: Path, uploaded: Path) -> None:
    (saved / "results.json").write_text(json.dumps({"markdown": TABLE}))
    LlakeyPolicy.from_pretrained(saved).push_to_hub("someone/llakey")
    card = _card(uploaded)
    assert TABLE in card.text and "LLaKey policy" in card.text
    assert card.data.to_dict()["library_name"] == "lerobot"
    assert {"llakey", "robotics"} <= set(card.data.tags)
    assert LlakeyPolicy.from_pretrained(uploaded).config.type == "llakey"
    assert {"policy_preprocessor.json", "policy_postprocessor.json"} <= {file.name for file in uploaded.iterdir()}


def test_lerobot_train_pushes_the_table_that_the_settings_name(
    make_tiny, keysteps, uploaded: Path, tmp_path: Path
) -> None:
    (tmp_path / "results.json").write_text(json.dumps({"episodes": [{"task": "close_jar", "success": True}]}))
    policy = make_tiny(results_path=str(tmp_path / "results.json"), repo_id="someone/llakey")
    config = TrainPipelineConfig(dataset=DatasetConfig(repo_id=keysteps.repo_id), policy=policy.config)
    policy.push_model_to_hub(config, dataset_meta=keysteps.meta)
    card = _card(uploaded)
    assert "| `close_jar` | 1 | 1 (100 %) |" in card.text
    assert keysteps.repo_id in card.text


def test_results_of_other_weights_are_left_out(saved: Path, make_tiny, training_batch, tmp_path: Path) -> None:
    (saved / "results.json").write_text(json.dumps({"markdown": TABLE}))
    trained = LlakeyPolicy.from_pretrained(saved).train()
    trained.forward(training_batch)
    make_tiny().action.save_pretrained(tmp_path / "action")
    config = PreTrainedConfig.from_pretrained(saved, cli_overrides=[f"--action_path={tmp_path / 'action'}"])
    changed = LlakeyPolicy.from_pretrained(saved, config=config)
    for policy in (trained, changed):
        text = policy.generate_model_card(None, "llakey", None, None).text
        assert TABLE not in text and "No evaluation results are known." in text


def test_a_plain_save_writes_no_card(saved: Path, tmp_path: Path) -> None:
    LlakeyPolicy.from_pretrained(saved).save_pretrained(tmp_path / "plain")
    assert sorted(file.name for file in (tmp_path / "plain").iterdir()) == ["config.json", "model.safetensors"]
