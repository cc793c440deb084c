"""The scales are read, and the smallest one runs from an empty folder to the report."""

from pathlib import Path

import draccus
import pytest

from lerobot_llakey.cli.reproduce import ReproduceConfig, reproduce
from lerobot_llakey.experiments.reproduction import Reproduction
from lerobot_llakey.experiments.settings import find_config


def read(scale: str, folder: Path, *arguments: str) -> ReproduceConfig:
    path = find_config(f"configs/reproduce_{scale}.yaml")
    config: ReproduceConfig = draccus.parse(
        ReproduceConfig, str(path), args=[f"--output_dir={folder}", "--estimate=false", *arguments]
    )
    return config


@pytest.mark.parametrize("scale", ["paper", "small", "toy", "smoke"])
def test_a_scale_is_read_and_its_stages_follow_from_one_another(scale: str, tmp_path: Path) -> None:
    config = read(scale, tmp_path)
    stages = Reproduction(config, tmp_path).stages()
    names = [stage.name for stage in stages]
    assert config.scale == scale and len(set(names)) == len(names)
    for index, stage in enumerate(stages):
        assert set(stage.needs) <= set(names[:index])
    assert {"collect", "keysteps", "compose", "abilities", "table", "rollback", "ambiguity"} <= set(names)


def test_the_papers_protocol(tmp_path: Path) -> None:
    config = read("paper", tmp_path)
    assert (config.table.num_episodes, config.table.repeats, config.max_steps) == (25, 6, 25)
    whole = Reproduction(config, tmp_path)
    assert len(whole.tasks) == 9 and len(whole.policies.rows(config.table)) == 5
    assert whole.policies.trainings["train_action"].steps == 100_000
    assert whole.policies.trainings["train_baseline"].batch_size == 20


def test_figure_1_uses_the_tables_action_policy_where_it_knows_the_task(tmp_path: Path) -> None:
    study = Reproduction(read("toy", tmp_path), tmp_path).ambiguity
    assert study is not None and study.after == ("train_action",)
    with pytest.raises(ValueError, match=r"set action\.recipe"):
        _ = Reproduction(read("toy", tmp_path, "--task=open_drawer"), tmp_path).ambiguity
    assert Reproduction(read("toy", tmp_path, "--ambiguity.num_demos=0"), tmp_path).ambiguity is None


@pytest.mark.slow
def test_the_smallest_scale_from_an_empty_folder(tmp_path: Path) -> None:
    reproduce(read("smoke", tmp_path))
    text = (tmp_path / "report.md").read_text()
    for title in ("Table I: success", "abilities", "Figure 6", "Figure 1", "## Time"):
        assert title in text
    for name in (
        "table/table.png",
        "abilities/3_views/abilities.png",
        "rollback/rollback.png",
        "ambiguity/ambiguity.png",
    ):
        assert (tmp_path / name).stat().st_size > 1000
    assert list(tmp_path.glob("table/videos/*/*.mp4")) and list(tmp_path.glob("ambiguity/videos/*/*.mp4"))
    markers = {path.name: path.read_text() for path in (tmp_path / "stages").iterdir()}
    reproduce(read("smoke", tmp_path))
    assert markers == {path.name: path.read_text() for path in (tmp_path / "stages").iterdir()}
    with pytest.raises(ValueError, match=r"stage train_action was begun, got a change of steps \(from 2 to 9\)"):
        reproduce(read("smoke", tmp_path, "--train.action.steps=9"))
