"""The verb foresees without leaving anything, and refuses in one sentence."""

from pathlib import Path

import pytest

from fakes_protocol import small_env
from lerobot_llakey import parallel
from lerobot_llakey.cli.table import TableConfig, run
from lerobot_llakey.evaluation.protocol import work


def test_a_dry_run_measures_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(parallel, "_kept", {})
    monkeypatch.setattr(work, "LlakeySimEnv", small_env)
    run(TableConfig(rows="expert", task="open_drawer", num_episodes=50, dry_run=True, output_dir=tmp_path / "table"))
    told = capsys.readouterr().out
    assert "300 episodes, 0 done; about" in told and "expert: 300 left" in told
    assert not (tmp_path / "table").exists()


def test_a_table_without_a_single_checkpoint_is_refused(tmp_path: Path) -> None:
    rows = tmp_path / "rows.yaml"
    rows.write_text(
        "- {name: ours, policy_path: no/where/at_all}\n"
        "- {name: chat, policy_path: nowhere, overrides: {command.base_url: , command.model: x}}\n"
    )
    reasons = r"ours: no checkpoint at no/where/at_all; chat: command\.base_url is not"
    with pytest.raises(FileNotFoundError, match=reasons):
        run(TableConfig(rows=str(rows), task="open_drawer", output_dir=tmp_path / "table"))
    assert not (tmp_path / "table").exists()
