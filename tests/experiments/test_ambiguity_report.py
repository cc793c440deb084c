"""Figures of figure 1 from made-up episodes."""

from pathlib import Path

import pytest

from lerobot_llakey.evaluation.protocol.plan import Trial
from lerobot_llakey.evaluation.protocol.records import Record
from lerobot_llakey.experiments.ambiguity_report import ambiguity_page, findings, plot_ambiguity, summarise
from lerobot_llakey.experiments.arms import BASELINE, LLAKEY, Arm, make_arms, make_plan
from lerobot_llakey.rollout.episode import Episode
from lerobot_llakey.sim.tasks.put_bulb import LOOSE, SCREWED

PLAN = make_plan(num_episodes=10, repeats=2)
TESTS = ["as_trained", "swapped"]
ARMS = make_arms(TESTS, {(method, "two"): Path("p") for method in (BASELINE, LLAKEY)}, Path("a"))


def record(arm: Arm, repeat: int, episode: int) -> Record:
    """As trained all are solved, swapped the loose ones alone, and then LLaKey unscrews them."""
    sequence = SCREWED if episode % 2 else LOOSE
    swapped = arm.test == "swapped"
    said = "screw the red light bulb out" if (sequence == SCREWED) != swapped else "grasp the red light bulb"
    solved = sequence == LOOSE or not swapped
    trial = Trial(arm.row.name, "put_bulb", "", repeat, episode, 10 * repeat + episode)
    words = [said] if arm.method == LLAKEY else [""]
    return Record(trial, Episode("put_bulb", "", trial.scene, 0, sequence, solved, words), "", None, 1.0)


RECORDS = [record(arm, repeat, episode) for arm in ARMS for repeat in range(2) for episode in range(10)]


def test_the_figures_of_an_arm() -> None:
    by_test = {(cells["method"], cells["test"]): cells for cells in summarise(PLAN, ARMS, RECORDS)}
    trained, swapped = by_test[LLAKEY, "as_trained"], by_test[LLAKEY, "swapped"]
    assert (trained["success"], swapped["success"]) == (1.0, 0.5)
    assert swapped["solved"] == {"loose": 10, "screwed": 0} and swapped["episodes"] == {"loose": 10, "screwed": 10}
    assert trained["unscrewed"] == {"loose": 0.0, "screwed": 1.0}
    assert swapped["unscrewed"] == {"loose": 1.0, "screwed": 0.0}
    assert by_test[BASELINE, "swapped"]["unscrewed"] is None


def test_what_follows_from_them_is_said_with_its_certainty() -> None:
    summary = summarise(PLAN, ARMS, RECORDS)
    assert findings(summary)[1] == "LLaKey, two wordings: -50 points with the other sequence's verbs."
    few = summarise(make_plan(2, 1), ARMS, [r for r in RECORDS if r.trial.repeat == 0 and r.trial.episode < 2])
    assert "intervals overlap" in findings(few)[0]


def test_the_page_has_the_papers_figures_beside_the_baseline(tmp_path: Path) -> None:
    summary = summarise(PLAN, ARMS, RECORDS)
    lines = ambiguity_page(PLAN, summary).splitlines()
    baseline = next(line for line in lines if line.startswith("| baseline") and "as trained" in line)
    assert baseline.split("|")[-2].strip() == "60"
    swapped = next(line for line in lines if line.startswith("| LLaKey") and "other sequence" in line)
    assert [cell.strip() for cell in swapped.split("|")[4:-1]] == ["50.0 ± 0.0", "10/10", "0/10", "100 % / 0 %", "-"]
    plot_ambiguity(tmp_path / "plot.png", summary)
    assert (tmp_path / "plot.png").read_bytes()[:4] == b"\x89PNG"


def test_an_arm_without_one_sequence_has_no_share_of_it() -> None:
    loose = [found for found in RECORDS if found.episode.sequence == LOOSE]
    cells = summarise(PLAN, ARMS, loose)[-1]
    assert cells["unscrewed"]["screwed"] is None
    assert cells["unscrewed"]["loose"] == pytest.approx(1.0)
