"""The arms of figure 1: a policy is told the wording of its arm, whatever the environment says."""

import pickle
from pathlib import Path

from lerobot_llakey.experiments.arms import BASELINE, LLAKEY, make_arms, make_plan
from lerobot_llakey.sim.tasks.put_bulb import LOOSE


def test_every_policy_meets_every_test() -> None:
    paths = {
        (method, training): Path(method + training) for method in (BASELINE, LLAKEY) for training in ("one", "two")
    }
    arms = make_arms(["as_trained", "removed"], paths, Path("action"))
    rows = [arm.row for arm in arms]
    assert len({row.slug for row in rows}) == 8
    llakey = next(row for row in rows if row.name == "LLaKey, two wordings, verbs removed")
    assert (llakey.command_path, llakey.action_path, llakey.policy_path) == ("LLaKeytwo", "action", "")
    baseline = next(row for row in rows if row.name == "baseline, one wording, as trained")
    assert (baseline.policy_path, baseline.command_path) == ("baselineone", "")


def test_the_policy_is_told_the_arms_wording() -> None:
    wording = make_arms(["swapped"], {(BASELINE, "two"): Path("a")}, None)[0].row.wording
    assert wording is not None
    told = wording("put the blue light bulb in the orange box", LOOSE)
    assert told == "unscrew the blue light bulb and put it into the orange box"
    assert pickle.loads(pickle.dumps(wording)) == wording  # so that other processes keep the policy


def test_all_arms_meet_the_same_scenes() -> None:
    arms = make_arms(["as_trained"], {(BASELINE, "one"): Path("a"), (BASELINE, "two"): Path("b")}, None)
    trials = make_plan(3, 2).trials([arm.row for arm in arms])
    scenes = [[trial.scene for trial in trials if trial.row == arm.row.name] for arm in arms]
    assert scenes[0] == scenes[1] == list(range(6))
