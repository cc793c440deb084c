"""The abilities of the rows' command policies are measured once and set beside the paper's."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.evaluation import lower_part
from lerobot_llakey.evaluation.lower_part import AbilitySamples, ability_page, measure_rows
from lerobot_llakey.evaluation.protocol.rows import Row
from lerobot_llakey.rollout.actors import Agent


class _Knows:
    """Names every instruction right at keyframes, and none in between."""

    def __init__(self) -> None:
        self.asked = 0

    def next_instructions(self, batch: dict[str, Any]) -> list[str]:
        self.asked += 1
        at_keyframe = batch[schema.IS_KEYFRAME].reshape(-1).tolist()
        return [
            text if keyframe else "raise the robotic arm"
            for text, keyframe in zip(batch[schema.INSTRUCTION], at_keyframe, strict=True)
        ]


def test_rows_with_a_command_policy_are_measured_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_keysteps(tmp_path / "keysteps")
    knows = _Knows()
    commands = {"ours": knows, "oracle": None}
    monkeypatch.setattr(
        lower_part,
        "load_row",
        lambda row: Agent(SimpleNamespace(command=commands[row.name]), lambda batch: batch, lambda action: action),
    )
    rows = [Row("ours", "x"), Row("oracle", "x")]
    samples = AbilitySamples(str(tmp_path / "keysteps"), "llakey/fake_keysteps")
    measured = measure_rows(rows, samples, tmp_path)
    assert list(measured) == ["ours"]
    assert measured["ours"]["sequential_prediction"]["all"]["exact"] == 1.0
    assert measured["ours"]["error_correction"]["all"]["exact"] == 0.0
    asked = knows.asked
    assert measure_rows(rows, samples, tmp_path) == measured and knows.asked == asked
    measure_rows(rows, AbilitySamples(samples.root, samples.repo_id, 4), tmp_path)
    assert knows.asked > asked
    page = ability_page(["open_drawer"], measured)
    assert "| ours " in page and "100.0" in page and "| *paper: LLaVA 13B (3)* | 89.8" in page
