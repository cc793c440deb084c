"""Made-up episodes of a table, whose figures can be worked out by hand."""

from __future__ import annotations

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND, Record
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.rollout.episode import Episode

ROWS = [Row("ours", "x", paper="LLaKey 13B (3)"), Row("other", "y")]
PLAN = Plan(("open_drawer", "close_jar"), num_episodes=2, repeats=4)
SOLVED = {"open_drawer": (0, 1, 2, 1), "close_jar": (2, 2, 2, 2)}
"""How many of the two episodes of each repeat are solved."""


def made_up_records(plan: Plan, disturbed: bool = False) -> list[Record]:
    records = []
    for trial in plan.trials(ROWS):
        success = trial.episode < SOLVED[trial.task][trial.repeat]
        struck = disturbed and trial.repeat > 0
        episode = Episode(
            trial.task, "", trial.scene, 0, 0, success, ["a"] * 3, [""] * 3, ["a"] * 3, [[0.0]] * 3, struck
        )
        attribution = "" if success or trial.row == "other" else (COMMAND, ACTION)[trial.episode]
        records.append(Record(trial, episode, attribution, None, 2.0))
    return records
