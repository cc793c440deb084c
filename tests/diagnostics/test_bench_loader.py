"""Loading is measured against training on the recipe's settings, and taken apart."""

from pathlib import Path

import draccus
import pytest
from lerobot.configs.train import TrainPipelineConfig
from lerobot.datasets.lerobot_dataset import LeRobotDataset

import lerobot_llakey  # noqa: F401 - registers the policies
from fakes import fake_keysteps
from lerobot_llakey.diagnostics import bench_loader
from lerobot_llakey.diagnostics.bench_loader import loading_cost, loading_speed

RECIPE = Path(__file__).parents[2] / "configs" / "action_small.yaml"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "data", episodes=1, frames=4)


def test_training_is_that_of_the_recipe() -> None:
    policy = draccus.parse(TrainPipelineConfig, str(RECIPE), args=[]).policy
    assert policy is not None
    default = type(policy)()
    costly = {"view_size", "crop_size", "widths", "blocks", "transformer_layers", "text_layers", "views", "stages"}
    costly |= {"dtype", "design", "colour_queries", "splat_radius", "rotation", "text_model", "muon"}
    assert {key for key in costly if getattr(policy, key) != getattr(default, key)} == set()


def test_more_batches_are_loaded_than_the_dataset_has(dataset: LeRobotDataset) -> None:
    assert loading_speed(dataset, batch_size=3, steps=4, workers=0) > 0


def test_workers_are_as_many_as_the_machine_has_cores(dataset: LeRobotDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_loader.os, "cpu_count", lambda: 4)
    asked: list[int] = []
    monkeypatch.setattr(bench_loader, "loading_speed", lambda *options: asked.append(options[-1]) or 60.0)
    figures = bench_loader.bench_loader(dataset, 2, 1, "cpu")
    assert asked == [0, 1, 2, 4]
    training = figures["training_samples_per_second"]
    assert figures["loading_to_training_4_workers"] == pytest.approx(60.0 / training)


def test_decoding_is_a_part_of_the_cost(dataset: LeRobotDataset) -> None:
    cost = loading_cost(dataset, [0, 1, 2] * 5)
    assert cost["processor_milliseconds_per_sample"] > 0
    assert 0 < cost["decoding_share"] < 1
