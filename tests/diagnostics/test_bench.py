"""Benchmarks measure what they say; how much is for a person to judge."""

from pathlib import Path
from typing import Any

import pytest

from lerobot_llakey.diagnostics.bench import BenchSettings, bench
from lerobot_llakey.diagnostics.processor import machine


def test_loader_is_measured(tmp_path: Path) -> None:
    figures = bench(BenchSettings("loader", num_episodes=1, batch_size=2, steps=1), tmp_path)
    speeds = [figures[name] for name in ("samples_per_second_1_workers", "training_samples_per_second")]
    assert figures["loading_to_training_1_workers"] == pytest.approx(speeds[0] / speeds[1])
    assert 0 < figures["decoding_share"] < 1
    assert figures["processor"] == machine()["processor"]
    assert {"load_before", "load_at_the_end"} <= figures.keys()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"part": "drawing"}, "part out of .* got 'drawing'"),
        ({"part": "loader", "steps": 0}, "--steps .* got 0"),
        ({"part": "batch", "policy_path": "any", "samples": -1}, "--samples .* got -1"),
        ({"part": "decision"}, "--policy_path"),
    ],
)
def test_bad_requests_are_told(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BenchSettings(**settings)
