import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from huggingface_hub import HfApi, ModelCard
from lerobot.configs import PreTrainedConfig
from lerobot.configs.default import DatasetConfig
from lerobot.configs.train import TrainPipelineConfig

from lerobot_llakey.policies.hierarchy.model_card import fill_card, known_results, read_results, results_table
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

TABLE = "| task | success |\n|---|---|\n| `close_jar` | 96 % |"


def test_counts_successes_by_task() -> None:
    episodes = [{"task": task, "success": done} for task, done in (("a", True), ("b", True), ("a", False))]
    table = results_table({"episodes": episodes}).splitlines()
    assert table[2:] == ["| `a` | 2 | 1 (50 %) |", "| `b` | 1 | 1 (100 %) |", "| average | 3 | 75 % |"]


def test_takes_a_finished_table_as_it_is() -> None:
    assert results_table({"markdown": "| a |\n|---|\n", "episodes": []}) == "| a |\n|---|"


def test_shows_the_rows_of_a_table_with_their_spread() -> None:
    half, all_ = {"success": 0.5, "spread": 0.04}, {"success": 1.0, "spread": 0.0}
    rows = {
        "LLaKey": {"tasks": {"a": half, "b": all_}, "average": half},
        "RVT": {"tasks": {"b": half}, "average": half},
    }
    assert results_table({"rows": rows, "settings": {}}).splitlines() == [
        "| success | `a` | `b` | average |",
        "|---|---|---|---|",
        "| LLaKey | 50.0 ± 4.0 | 100.0 ± 0.0 | 50.0 ± 4.0 |",
        "| RVT |  | 50.0 ± 4.0 | 50.0 ± 4.0 |",
    ]


@pytest.mark.parametrize(
    "results",
    [{}, {"rows": [1]}, {"rows": {"LLaKey": {"shift": {}}}}, {"episodes": []}, {"episodes": [{"task": "a"}]}, [1]],
)
def test_other_figures_are_refused(results, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="Expected results with a table under 'markdown'"):
        results_table(results)
    (tmp_path / "results.json").write_text(json.dumps(results))
    with pytest.raises(ValueError, match=r"results\.json: Expected results"):
        read_results(tmp_path)


def test_the_setting_comes_before_the_folder(tmp_path: Path) -> None:
    assert known_results(None, None) is known_results(None, tmp_path) is None
    (tmp_path / "results.json").write_text(json.dumps({"markdown": "of the folder"}))
    (tmp_path / "other.json").write_text(json.dumps({"markdown": "of the setting"}))
    assert known_results(None, tmp_path) == "of the folder"
    assert known_results(str(tmp_path / "other.json"), tmp_path) == "of the setting"
    with pytest.raises(FileNotFoundError, match="Expected the results of an evaluation at"):
        known_results(str(tmp_path / "nowhere.json"), tmp_path)


def test_a_card_without_a_place_for_results_gets_one() -> None:
    card = fill_card(ModelCard("---\nlicense: mit\n---\n# A card"), "| a |")
    assert card.text.count("## Evaluation\n\n| a |") == 1
    assert "LLaKey policy" in card.text
    assert "Evaluation" not in fill_card(ModelCard("---\nlicense: mit\n---\n# A card"), None).text


@pytest.fixture(autouse=True)
def _offline(monkeypatch) -> None:
    """LeRobot lets the Hub look over each card."""
    monkeypatch.setattr(ModelCard, "validate", lambda self, **_: None)


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
    assert "_No evaluation results" not in card.text
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
        assert TABLE not in text and "_No evaluation results" in text


def test_a_plain_save_writes_no_card(saved: Path, tmp_path: Path) -> None:
    LlakeyPolicy.from_pretrained(saved).save_pretrained(tmp_path / "plain")
    assert sorted(file.name for file in (tmp_path / "plain").iterdir()) == ["config.json", "model.safetensors"]
