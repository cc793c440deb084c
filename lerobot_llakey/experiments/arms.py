"""The arms of figure 1: which policy, trained with which wording, is tested with which."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.evaluation.protocol.plan import Plan
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.experiments.wordings import TASK_NAME, TESTS, TestedWording
from lerobot_llakey.sim.settings import MAX_STEPS

LLAKEY, BASELINE = "LLaKey", "baseline"


@dataclass(frozen=True)
class Arm:
    """One policy under one test.

    Attributes:
        method: LLAKEY or BASELINE.
        training: "one" or "two" wordings.
        test: out of TESTS.
        policy_path: of the baseline.
        command_path, action_path: of LLaKey.
    """

    method: str
    training: str
    test: str
    policy_path: str = ""
    command_path: str = ""
    action_path: str = ""

    @property
    def row(self) -> Row:
        """As a row of a table."""
        wordings = "one wording" if self.training == "one" else "two wordings"
        name = f"{self.method}, {wordings}, {TESTS[self.test]}"
        wording = TestedWording(self.training, self.test)
        return Row(name, self.policy_path, self.command_path, self.action_path, wording=wording)


def make_arms(tests: Sequence[str], policies: Mapping[tuple[str, str], Path], action: Path | None) -> list[Arm]:
    """All arms.

    Args:
        tests: wordings tested.
        policies: checkpoints by method and training; of LLaKey its command policy.
        action: checkpoint of LLaKey's action policy.
    """
    arms: list[Arm] = []
    for (method, training), path in policies.items():
        paths = {"command_path": str(path), "action_path": str(action)}
        arms += [
            Arm(method, training, test, **(paths if method == LLAKEY else {"policy_path": str(path)})) for test in tests
        ]
    return arms


def make_plan(num_episodes: int, repeats: int, max_steps: int = MAX_STEPS, split: str = "test") -> Plan:
    """The episodes of each arm."""
    return Plan((TASK_NAME,), num_episodes, repeats, max_steps, split, attribution=False)
