from pathlib import Path

import pytest

from lerobot_llakey.cli import dagger
from lerobot_llakey.cli.dagger import DaggerConfig, run


def test_options_reach_the_collection(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    called: list[tuple] = []
    monkeypatch.setattr(dagger, "collect", lambda *arguments: called.append(arguments))
    monkeypatch.setattr(dagger, "inspect_checkpoint", lambda path: path)
    run(DaggerConfig("some/policy", "open_drawer,close_jar", 4, tmp_path / "d", expert_share=0.5, num_workers=3))
    settings, root, repo_id, num_workers = called[0]
    assert settings.policy_path == "some/policy"
    assert (settings.tasks, settings.num_episodes) == (("open_drawer", "close_jar"), 4)
    assert (settings.expert_share, settings.split, settings.first_seed) == (0.5, "train", 100_000)
    assert (root, repo_id, num_workers) == (tmp_path / "d", "local/llakey_dagger", 3)


def test_a_policy_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="Expected a checkpoint folder or a Hub name"):
        run(DaggerConfig("no/such/policy", "open_drawer", 1, tmp_path / "d", num_workers=1))
