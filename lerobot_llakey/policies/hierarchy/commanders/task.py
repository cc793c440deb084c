"""Nobody commands: the skill instruction itself reaches the action policy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said


class TaskCommander(Commander):
    """Says the skill instruction at every step."""

    def ask(
        self,
        batch: Mapping[str, Any],
        rows: Sequence[int],
        previous: Sequence[str],
        sample: bool = False,
        seeds: Sequence[int] = (),
    ) -> list[Said]:
        texts = batch.get(schema.TASK)
        if texts is None:
            raise LlakeyError(
                f"Expected {schema.TASK!r} in the batch for commander='task', got {sorted(batch)}; use an environment "
                "that has it or commander=policy."
            )
        return [Said(texts if isinstance(texts, str) else str(texts[row]), "task") for row in rows]
