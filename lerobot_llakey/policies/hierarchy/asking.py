"""Asking again: a command that gets nowhere or cannot be read is drawn anew before anything is left to chance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor


def is_stuck(supervisor: Supervisor, said: Said) -> bool:
    """Whether words of the command policy are unreadable, or repeat what did not move the arm.

    The arm does not move where the pose is out of reach, where the way is blocked, and where the hand is there already.
    """
    if said.source != "policy":
        return False
    reading = supervisor.reading(said.text)
    return reading is None or (supervisor.moved is False and reading == supervisor.previous)


def ask_again(
    commander: Commander,
    batch: Mapping[str, Any],
    said: Sequence[Said],
    supervisors: Sequence[Supervisor],
    attempts: int,
) -> tuple[list[Said], list[int]]:
    """Ask for other words in the rows that are stuck, with sampling, until they are not or the attempts are used up.

    Args:
        commander: who gave the words.
        batch: the observation of all rows.
        said: the words of each row.
        supervisors: of each row; their generators seed the draws.
        attempts: how often a row is asked again at most.

    Returns:
        The words of each row: the first that help. Where none do, the first that can be read, if the ones given before
        cannot, else these. And how often each row was asked again.
    """
    chosen, asked = list(said), [0] * len(said)
    stuck = [row for row, supervisor in enumerate(supervisors) if is_stuck(supervisor, chosen[row])]
    for _ in range(attempts):
        if not stuck:
            break
        seeds = [int(supervisors[row].rng.integers(2**63)) for row in stuck]
        previous = [supervisors[row].previous for row in stuck]
        answers = commander.ask(batch, stuck, previous, sample=True, seeds=seeds)
        for row, answer in zip(stuck, answers, strict=True):
            asked[row] += 1
            readable = supervisors[row].reading(chosen[row].text) is not None
            if not is_stuck(supervisors[row], answer) or (
                not readable and supervisors[row].reading(answer.text) is not None
            ):
                chosen[row] = answer
        stuck = [row for row in stuck if is_stuck(supervisors[row], chosen[row])]
    return chosen, asked
