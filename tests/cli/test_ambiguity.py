"""``llakey ambiguity`` fills in the recipes, and trains no action policy where one is given."""

from pathlib import Path

import pytest

from fakes_action import small_config
from lerobot_llakey.cli import ambiguity
from lerobot_llakey.cli.ambiguity import PAGE, AmbiguityConfig, run
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments.stages import Ledger
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy


@pytest.fixture
def stages(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    found: list[str] = []

    def run_stages(ledger: Ledger, side_by_side: int) -> None:
        found.extend(ledger.stages)
        page = ledger.folder.parent / PAGE
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(f"the page, {side_by_side} at a time")

    monkeypatch.setattr(ambiguity, "run_stages", run_stages)
    return found


def test_the_small_recipes_are_the_defaults(
    tmp_path: Path, stages: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    config = AmbiguityConfig(output_dir=tmp_path / "out", side_by_side=2)
    config.command.recipe = "configs/command_small_wrist.yaml"
    run(config)
    assert config.action.recipe == "configs/action_small.yaml"
    assert config.command.recipe == "configs/command_small_wrist.yaml"
    assert "ambiguity_action" in stages and "the page, 2 at a time" in capsys.readouterr().out


def test_an_action_policy_that_is_given_is_not_trained(tmp_path: Path, stages: list[str]) -> None:
    LlakeyActionPolicy(small_config()).save_pretrained(tmp_path / "action")
    run(AmbiguityConfig(action_path=tmp_path / "action", output_dir=tmp_path / "out"))
    assert stages and "ambiguity_action" not in stages
    with pytest.raises(LlakeyError, match="Expected a checkpoint"):
        run(AmbiguityConfig(action_path=tmp_path / "nothing" / "here", output_dir=tmp_path / "other"))
