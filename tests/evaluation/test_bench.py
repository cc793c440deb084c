"""Benchmarks measure what they say; how much is for a person to judge."""

from pathlib import Path

import pytest

from lerobot_llakey.evaluation.bench import bench, machine


def test_loader_is_measured(tmp_path: Path) -> None:
    figures = bench("loader", num_episodes=1, batch_size=2, steps=1, device="cpu", workdir=tmp_path)
    speeds = [figures[name] for name in ("samples_per_second_1_workers", "training_samples_per_second")]
    assert figures["loading_to_training_1_workers"] == pytest.approx(speeds[0] / speeds[1])
    assert 0 < figures["decoding_share"] < 1
    assert figures["cores"] == machine()["cores"]


@pytest.mark.parametrize(("part", "steps"), [("drawing", 1), ("loader", 0)])
def test_bad_requests_are_told(tmp_path: Path, part: str, steps: int) -> None:
    with pytest.raises(ValueError, match="Expected"):
        bench(part, num_episodes=1, batch_size=2, steps=steps, device="cpu", workdir=tmp_path)
