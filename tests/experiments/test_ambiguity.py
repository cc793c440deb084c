"""The study of verbs: its stages follow from one another, and its last one writes figure 1 from the episodes."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import Record, Records
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.experiments import ambiguity
from lerobot_llakey.experiments.ambiguity import PAGE, PLOT, Ambiguity
from lerobot_llakey.experiments.arms import LLAKEY
from lerobot_llakey.experiments.settings import AmbiguitySettings, TrainingSettings
from lerobot_llakey.rollout.episode import Episode
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED

TRAINING = TrainingSettings("configs/action_small.yaml", steps=10)
SETTINGS = AmbiguitySettings(num_demos=4, num_episodes=2, repeats=1, num_videos=0, command=TRAINING, baseline=TRAINING)


def test_stages_need_only_earlier_ones_and_the_given_action_policy_is_not_trained(tmp_path: Path) -> None:
    given = Ambiguity(SETTINGS, tmp_path, action=tmp_path / "action", after=("train_action",))
    own = Ambiguity(replace(SETTINGS, action=TRAINING), tmp_path, action=tmp_path / "action")
    for study, known in ((given, {"train_action"}), (own, set())):
        for stage in study.stages():
            assert set(stage.needs) <= known
            known = known | {stage.name}
    assert len(given.trainings) + 1 == len(own.trainings)
    llakey = [arm for arm in given.arms if arm.method == LLAKEY]
    assert llakey and {arm.action_path for arm in llakey} == {str(tmp_path / "action")}
    assert {Path(arm.action_path) for arm in own.arms if arm.method == LLAKEY} == {
        own.trainings["ambiguity_action"].checkpoint
    }


def test_without_any_action_policy_it_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match=r"got neither; set action\.recipe"):
        Ambiguity(SETTINGS, tmp_path)


def test_the_study_writes_figure_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run_missing(plan: Plan, rows: Sequence[Row], records: Records, num_workers: int) -> None:
        for trial in plan.trials(rows):
            sequence = SCREWED if trial.episode else LOOSE
            records.add(Record(trial, Episode("put_bulb", "", trial.scene, 0, sequence, True), "", None, 1.0))

    monkeypatch.setattr(ambiguity, "run_missing", run_missing)
    study = Ambiguity(SETTINGS, tmp_path, action=tmp_path / "action")
    work = study.stages()[-1].work
    assert work is not None
    work()
    figures = json.loads((tmp_path / "results.json").read_text())
    assert len(figures["arms"]) == len(study.arms) and all(arm["success"] == 1.0 for arm in figures["arms"])
    assert (tmp_path / PAGE).read_text().startswith("# Do the verbs matter?") and (tmp_path / PLOT).is_file()
