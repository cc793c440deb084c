"""``llakey bench`` prints what was measured and writes it."""

import json
from pathlib import Path
from typing import Any

import pytest

from lerobot_llakey.cli import bench
from lerobot_llakey.cli.bench import BenchConfig, run
from lerobot_llakey.diagnostics.bench import BenchSettings
from lerobot_llakey.errors import LlakeyError


def test_figures_are_printed_and_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[BenchSettings] = []

    def measure(settings: BenchSettings) -> dict[str, Any]:
        asked.append(settings)
        return {"renders_per_second": 12.34567, "gpu": None}

    monkeypatch.setattr(bench, "bench_in_temporary_folder", measure)
    run(BenchConfig("render", steps=3, device="cpu", output_dir=tmp_path))
    assert asked == [BenchSettings("render", steps=3, device="cpu")]
    told = capsys.readouterr().out
    assert "| renders_per_second | 12.35 |" in told and "None" in told
    assert json.loads((tmp_path / "results.json").read_text())["renders_per_second"] == 12.34567


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (BenchConfig("nothing"), "Expected a part out of"),
        (BenchConfig("decision"), "Expected the policy's checkpoint"),
        (BenchConfig("render", policy_path="x"), "Expected --policy_path with"),
        (BenchConfig("batch", policy_path="nowhere/at/all"), "Expected a checkpoint"),
    ],
)
def test_what_cannot_be_measured_is_refused_at_once(config: BenchConfig, words: str) -> None:
    with pytest.raises(LlakeyError, match=words):
        run(config)
