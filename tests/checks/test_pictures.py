"""Pictures that do not fit calibration and states are told by the gripper, which is then elsewhere."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from fakes import fake_cameras, render_balls
from lerobot_llakey import schema
from lerobot_llakey.checks.pictures import Sample, check_pictures
from lerobot_llakey.geometry import pose_to_matrix

SIZE = 64


@pytest.fixture(scope="module")
def sample() -> Sample:
    """Twelve frames in which a ball stands for the gripper, above the table and beside its middle."""
    rng = np.random.default_rng(0)
    intrinsics, extrinsics = fake_cameras(SIZE)
    places = np.stack((rng.uniform(0.4, 0.6, 12), rng.uniform(0.06, 0.16, 12), rng.uniform(0.2, 0.3, 12)), axis=1)
    colours: dict[str, np.ndarray] = {}
    depths: dict[str, np.ndarray] = {}
    for number, camera in enumerate(schema.CAMERAS):
        seen = [
            render_balls(place[None], np.array([[0.9, 0.1, 0.1]]), intrinsics[number], extrinsics[number], SIZE)
            for place in places
        ]
        colours[camera] = np.stack([rgb for rgb, _ in seen]) / 255
        depths[camera] = np.stack([depth[..., 0] for _, depth in seen]) / 1000
    hands = np.zeros((12, schema.HAND_DIM))
    hands[:, :3] = places
    actions = np.zeros((12, schema.ACTION_DIM))
    actions[:, :3] = places
    matrices = pose_to_matrix(extrinsics.astype(float))
    known = {camera: np.tile(intrinsics[number], (12, 1)) for number, camera in enumerate(schema.CAMERAS)}
    stands = {camera: np.tile(matrices[number], (12, 1, 1)) for number, camera in enumerate(schema.CAMERAS)}
    return Sample(schema.CAMERAS, colours, depths, known, stands, hands, actions)


def test_sound_pictures_give_no_warning(sample: Sample) -> None:
    assert list(check_pictures(sample)) == []


def with_depth(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Sample], Sample]:
    return lambda sample: replace(sample, depths={name: change(depth) for name, depth in sample.depths.items()})


def swapped(sample: Sample) -> Sample:
    left, right = "left_shoulder", "right_shoulder"
    swap = {left: sample.extrinsics[right], right: sample.extrinsics[left]}
    return replace(sample, extrinsics=sample.extrinsics | swap)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (with_depth(lambda depth: depth[..., ::-1]), "mirrored left to right"),
        (with_depth(lambda depth: depth / 10), "in centimetres"),
        (with_depth(lambda depth: depth / 100), "in decimetres"),
        (with_depth(lambda depth: depth / 1000), "metres?"),
        (with_depth(lambda depth: np.full_like(depth, 0.5)), "500 mm in every pixel"),
        (with_depth(lambda depth: np.random.default_rng(1).uniform(0.5, 3.0, depth.shape)), "noise?"),
        (swapped, "where camera right_shoulder does"),
        (lambda sample: replace(sample, colours={name: v * 0 for name, v in sample.colours.items()}), "0 in every"),
    ],
)
def test_spoilt_pictures_are_told_apart(spoil: Callable[[Sample], Sample], said: str, sample: Sample) -> None:
    sentences = [finding.sentence("it") for finding in check_pictures(spoil(sample))]
    assert any(said in sentence for sentence in sentences), sentences
