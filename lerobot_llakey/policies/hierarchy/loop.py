"""The loop of algorithm 1 of the paper over all rows of a batch, without the networks."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import read_hands
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.episode_key import episode_key
from lerobot_llakey.policies.hierarchy.log import EpisodeLog
from lerobot_llakey.policies.hierarchy.record import Step
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor, SupervisorSettings


class Loop:
    """What the hierarchical policy remembers of its episodes: one supervisor a row, and the log.

    A step is :meth:`instruct`, the action policy, then :meth:`send`. The steps of an episode come from one thread.

    Args:
        config: of the hierarchical policy.

    Attributes:
        supervisors: one for each row since the last :meth:`reset`.
        log: the steps since then.
    """

    def __init__(self, config: LlakeyConfig) -> None:
        self.config = config
        self.supervisors: list[Supervisor] = []
        self.log = EpisodeLog(config.log_dir)
        self._said: list[Said] = []
        self._thread: int | None = None

    def reset(self) -> None:
        """Forget all episodes; the next batch sets the number of rows."""
        self.supervisors = []
        self.log.begin((), self.config.seed)
        self._thread = None

    def instruct(self, commander: Commander, batch: Mapping[str, Any]) -> list[str]:
        """The instruction to carry out in each row.

        Args:
            commander: who is asked.
            batch: the observation, with ``observation.state``.

        Raises:
            LlakeyError: if the state is missing, or the number of rows or the thread changed without a reset.
        """
        if schema.STATE not in batch:
            raise LlakeyError(
                f"Expected {schema.STATE!r} in the batch, got {sorted(batch)}; use an environment that has it."
            )
        states = self._hands(batch)
        self._begin(batch, len(states))
        for supervisor, state in zip(self.supervisors, states, strict=True):
            supervisor.observe(state)
        commander.observe(states)
        said = self._said = commander.ask(batch, range(len(states)), [row.previous for row in self.supervisors])
        return [
            row.accept(one.text, counted=one.source != "person")
            for row, one in zip(self.supervisors, said, strict=True)
        ]

    def send(self, commander: Commander, batch: Mapping[str, Any], proposed: np.ndarray) -> np.ndarray:
        """The actions (B, 9) to execute, given those that the action policy proposed (B, 9); the step is logged."""
        states = self._hands(batch)
        tasks = batch.get(schema.TASK, "")
        sent, steps = [], []
        for index, (row, said) in enumerate(zip(self.supervisors, self._said, strict=True)):
            repeats, random_moves = row.repeats, row.random_moves
            sent.append(row.adjust(proposed[index], states[index]))
            steps.append(
                Step(
                    row=index,
                    index=len(self.log.steps[index]),
                    task=tasks if isinstance(tasks, str) else str(tasks[index]),
                    said=said.text,
                    instruction=row.previous,
                    source=said.source if row.took == "said" else row.took,
                    likelihood=said.likelihood if row.took == "said" else None,
                    unparsable=row.took != "said",
                    repeats=repeats,
                    random_move=row.random_moves > random_moves,
                    moved=row.moved,
                    state=_plain(states[index]),
                    proposed=_plain(proposed[index]),
                    sent=_plain(sent[-1]),
                )
            )
        self.log.add(steps)
        commander.sent(steps)
        return np.stack(sent)

    def _hands(self, batch: Mapping[str, Any]) -> np.ndarray:
        hands: np.ndarray = read_hands(batch, self.config.action.hand_columns).float().cpu().numpy()
        return hands

    def _begin(self, batch: Mapping[str, Any], rows: int) -> None:
        """Set up the rows at the first step of their episodes."""
        if not self.supervisors:
            self._thread = threading.get_ident()
            settings = supervisor_settings(self.config)
            keys = [episode_key(batch, row) for row in range(rows)]
            rngs = [np.random.default_rng((self.config.seed, key)) for key in keys]
            self.supervisors = [Supervisor(settings, rng) for rng in rngs]
            self.log.begin(keys, self.config.seed)
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


def supervisor_settings(config: LlakeyConfig) -> SupervisorSettings:
    """The part of a policy's settings that its supervisors need."""
    return SupervisorSettings(
        repeat_threshold=config.repeat_threshold,
        random_move_probability=config.random_move_probability,
        random_move_radius=config.random_move_radius,
        workspace=config.action.box,
        fallback=config.fallback,
        grammar=config.spoken,
        count_repeats=config.commander != "task",
        screw_about_tool_axis=config.screw_about_tool_axis,
        raise_upward=config.raise_upward,
        still_distance=config.still_distance,
        still_degrees=config.still_degrees,
    )


def _plain(values: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(value), 6) for value in values)
