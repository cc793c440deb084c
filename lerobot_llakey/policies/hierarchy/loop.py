"""The loop of algorithm 1 of the paper over all rows of a batch, without the networks."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from hashlib import blake2b
from typing import Any

import numpy as np
import torch

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import read_hands, read_numbers
from lerobot_llakey.policies.hierarchy.commanders import Commander
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.corrections import Corrections
from lerobot_llakey.policies.hierarchy.decision import Decision, Said, choose
from lerobot_llakey.policies.hierarchy.step_log import EpisodeLog, Step
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor


class Loop:
    """What the hierarchical policy remembers of its episodes: one supervisor a row, and the log.

    A step is :meth:`decide`, the action policy, then :meth:`commit`. The steps of an episode come from one thread.

    Args:
        config: of the hierarchical policy.
        commander: who gives the instructions; another may be put in its place.

    Attributes:
        corrections: where a person's words and goals go, which come before the commander's.
        supervisors: one for each row since the last :meth:`reset`.
        log: the steps since then.
    """

    def __init__(self, config: LlakeyConfig, commander: Commander) -> None:
        self.config, self.commander = config, commander
        self.corrections = Corrections(config.spoken)
        self.supervisors: list[Supervisor] = []
        self.log = EpisodeLog(config.log_dir)
        self._thread: int | None = None

    def reset(self) -> None:
        """Forget all episodes; the next batch sets the number of rows."""
        self.supervisors = []
        self.log.begin((), self.config.seed)
        self._thread = None
        self.commander.reset()
        self.corrections.reset()

    def decide(self, batch: Mapping[str, Any], known: Decision | None = None) -> Decision:
        """The instruction to carry out in each row; nothing is remembered or changed.

        Args:
            batch: the observation, with ``observation.state``.
            known: what was decided about the same observation before: the commander is not asked again what it has
                answered then.

        Raises:
            LlakeyError: if something in the batch is missing or wrong, or the number of rows or the thread changed
                without a reset.
        """
        hands: np.ndarray = read_hands(batch, self.config.action.hand_columns).float().cpu().numpy()
        rows = range(len(hands))
        for key in map(schema.image_key, schema.cameras_of(batch)):
            read_numbers(batch, key, ("channels", "height", "width"), len(rows))
        self._check(len(rows))
        last = [row.last for row in self.supervisors] or [None] * len(rows)
        goals, batch = self.corrections.goals(batch, len(rows))
        given = {row: Said(text, "person") for row, text in self.corrections.standing(hands).items()}
        answers = {} if known is None else dict(known.answers)
        if asked := [row for row in rows if row not in given and (row, goals[row]) not in answers]:
            previous = ["" if (choice := last[row]) is None else choice.instruction for row in asked]
            for row, said in zip(asked, self.commander.ask(batch, asked, previous), strict=True):
                answers[row, goals[row]] = said
        grammar, fallback = self.config.spoken, self.config.fallback
        said_now = [given[row] if row in given else answers[row, goals[row]] for row in rows]
        choices = [choose(said, before, grammar, fallback) for said, before in zip(said_now, last, strict=True)]
        batch = {**batch, schema.INSTRUCTION: [choice.instruction for choice in choices]}
        return Decision(batch, hands, goals, choices, answers)

    def commit(self, decision: Decision, proposed: np.ndarray) -> list[Step]:
        """Carry a decision out: remember it, log it, and tell the commander.

        Args:
            decision: the latest one.
            proposed: (B, 9) what the action policy proposed for its batch.

        Returns:
            One step for each row, with the action to send.
        """
        self._begin(decision)
        steps = []
        for index, (row, choice) in enumerate(zip(self.supervisors, decision.choices, strict=True)):
            row.observe(decision.hands[index])
            row.accept(choice)
            repeats, random_moves = row.repeats, row.random_moves
            sent = row.adjust(proposed[index], decision.hands[index])
            steps.append(
                Step(
                    row=index,
                    index=len(self.log.steps[index]),
                    task=decision.goals[index],
                    said=choice.said,
                    instruction=choice.instruction,
                    source=choice.source,
                    likelihood=choice.likelihood,
                    unparsable=choice.unparsable,
                    repeats=repeats,
                    random_move=row.random_moves > random_moves,
                    moved=row.moved,
                    state=tuple(map(float, decision.hands[index])),
                    proposed=tuple(map(float, proposed[index])),
                    sent=tuple(map(float, sent)),
                )
            )
        self.log.add(steps)
        self.corrections.sent(steps)
        self.commander.sent(steps)
        return steps

    def _check(self, rows: int) -> None:
        if not self.supervisors:
            return
        if self._thread != threading.get_ident():
            raise LlakeyError(
                "Expected all steps of an episode from one thread, got one from another thread: the policy remembers "
                "its episodes; set --env.max_parallel_tasks=1 and raise --eval.batch_size in place of it."
            )
        if len(self.supervisors) != rows:
            raise LlakeyError(
                f"Expected a batch of {len(self.supervisors)} rows as in the step before, got {rows}; call reset() "
                "between episodes."
            )

    def _begin(self, decision: Decision) -> None:
        """Set up the rows at the first step of their episodes."""
        if not self.supervisors:
            self._thread = threading.get_ident()
            keys = [episode_key(decision.batch, row) for row in range(len(decision.choices))]
            rngs = [np.random.default_rng((self.config.seed, key)) for key in keys]
            self.supervisors = [Supervisor(self.config, rng) for rng in rngs]
            self.log.begin(keys, self.config.seed)


def episode_key(batch: Mapping[str, Any], row: int) -> int:
    """What tells one episode from another without being told: a number below 2**64 for its first observation.

    It depends on a row's goal, state and pictures alone, not on the row's place in the batch. Random moves are seeded
    with it, so that an episode goes the same way alone and among others.

    Args:
        batch: the first observation of the episodes.
        row: of the batch.
    """
    digest = blake2b(digest_size=8)
    task = batch.get(schema.TASK, "")
    digest.update((task if isinstance(task, str) else str(task[row])).encode())
    for key in (schema.STATE, *sorted(map(schema.image_key, schema.cameras_of(batch)))):
        value = batch.get(key)
        if isinstance(value, torch.Tensor):
            digest.update(value[row].detach().cpu().float().contiguous().numpy().tobytes())
    return int.from_bytes(digest.digest(), "big")
