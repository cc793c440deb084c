"""Nobody commands: the skill instruction itself reaches the action policy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.texts import text_column


class TaskCommander(Commander):
    """Says the skill instruction at every step."""

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        texts = text_column(batch, schema.TASK)
        return [Said(texts[0] if isinstance(batch[schema.TASK], str) else texts[row], "task") for row in rows]
