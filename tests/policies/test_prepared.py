"""A dataset's texts come through a policy's preprocessor."""

from typing import Any

from lerobot_llakey import schema
from lerobot_llakey.policies.prepared import prepared


def test_texts_come_past_a_preprocessor_that_drops_them() -> None:
    def dropping(batch: dict[str, Any]) -> dict[str, Any]:
        return {schema.TASK: [text.upper() for text in batch[schema.TASK]]}

    batch = {schema.TASK: ["close it"], schema.INSTRUCTION: ["grasp the lid"], "other": 1}
    assert prepared(batch, dropping) == {schema.TASK: ["CLOSE IT"], schema.INSTRUCTION: ["grasp the lid"]}
    assert prepared(batch, None) == batch
