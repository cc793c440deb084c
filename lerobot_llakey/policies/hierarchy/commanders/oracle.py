"""The expert in the environment commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.texts import text_column


class OracleCommander(Commander):
    """Passes on the expert's instruction that the environment sends along."""

    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        if schema.ORACLE_INSTRUCTION not in batch:
            raise LlakeyError(
                f"Expected {schema.ORACLE_INSTRUCTION!r} in the batch for commander='oracle', got {sorted(batch)}; "
                "switch it on in the environment (--env.oracle_instructions=true) or use commander=policy."
            )
        # Empty where the expert has nothing left to do.
        texts = text_column(batch, schema.ORACLE_INSTRUCTION, may_be_empty=True)
        return [Said(texts[row], "oracle") for row in rows]
