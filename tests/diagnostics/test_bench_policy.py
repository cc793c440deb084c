"""A policy's speeds are those of the settings asked for."""

from pathlib import Path

import pytest

import lerobot_llakey  # noqa: F401 - registers the policies
from fakes import fake_keysteps
from lerobot_llakey.diagnostics.bench_policy import bench_policy


@pytest.mark.parametrize("kind", ["llakey_action", "llakey_command"])
def test_training_and_deciding_are_measured(kind: str, tmp_path: Path) -> None:
    dataset = fake_keysteps(tmp_path / "data", episodes=1, frames=2)
    small = {"view_size": 32} if kind == "llakey_action" else {"image_size": 32, "patch_size": 16}
    figures = bench_policy(kind, dataset, batch_size=2, steps=1, device="cpu", **small)
    assert figures["training_samples_per_second"] > 0 and figures["decision_milliseconds"] > 0
    for name in ("training_samples_per_second", "decision_milliseconds"):
        assert figures[f"{name}_float32"] > 0
    assert figures["training_step_time_against_float32"] == pytest.approx(
        figures["training_samples_per_second_float32"] / figures["training_samples_per_second"]
    )
    assert (figures["policy"], figures["batch_size"]) == (kind, 2)
    fewer = bench_policy(kind, dataset, batch_size=2, steps=1, device="cpu", **small, **NARROW[kind])
    assert fewer["parameters"] < figures["parameters"]


NARROW = {"llakey_action": {"text_layers": 1}, "llakey_command": {"text_layers": 1}}
