import pytest
import torch

from lerobot_llakey.policies.command.images import augment, resize, stack_views


def test_views_come_in_the_order_of_the_keys():
    batch = {f"observation.images.{name}": torch.full((2, 3, 8, 8), value) for name, value in (("a", 0.1), ("b", 0.9))}
    stacked = stack_views(batch, ["observation.images.b", "observation.images.a"])
    assert stacked.shape == (2, 2, 3, 8, 8)
    assert stacked[0, :, 0, 0, 0].tolist() == pytest.approx([0.9, 0.1])


def test_a_view_of_another_size_is_resized_to_the_first():
    batch = {"observation.images.a": torch.zeros(1, 3, 8, 8), "observation.images.b": torch.ones(1, 3, 16, 16)}
    assert stack_views(batch, list(batch)).shape == (1, 2, 3, 8, 8)


def test_a_missing_view_and_a_wrong_shape_are_named():
    with pytest.raises(ValueError, match=r"add observation\.images\.b"):
        stack_views({"observation.images.a": torch.zeros(1, 3, 8, 8)}, ["observation.images.a", "observation.images.b"])
    with pytest.raises(ValueError, match=r"observation.images.a of shape \(batch, 3, height, width\), got \(3, 8, 8\)"):
        stack_views({"observation.images.a": torch.zeros(3, 8, 8)}, ["observation.images.a"])


def test_shift_moves_a_dot_by_no_more_than_asked():
    images = torch.zeros(16, 2, 3, 17, 17)
    images[..., 8, 8] = 1.0
    shifted = augment(images, shift=3, jitter=0.0)
    positions = shifted[:, :, 0].flatten(0, 1).flatten(1).argmax(1)
    offsets = torch.stack((positions // 17 - 8, positions % 17 - 8))
    assert offsets.abs().max() <= 3
    assert len(offsets.unique(dim=1).T) > 5
    assert torch.equal(shifted.sum((-1, -2)), images.sum((-1, -2)))


def test_jitter_changes_all_views_of_a_sample_alike_and_samples_apart():
    images = torch.full((4, 2, 3, 4, 4), 0.4)
    changed = augment(images, shift=0, jitter=0.2)
    assert torch.allclose(changed[:, 0], changed[:, 1])
    assert changed[:, 0, 0, 0, 0].unique().numel() == 4
    assert (changed - images).abs().max() <= 0.2


def test_nothing_changes_when_both_are_off():
    images = torch.rand(2, 1, 3, 8, 8)
    assert torch.equal(augment(images, 0, 0.0), images)


def test_resize():
    assert resize(torch.rand(2, 3, 8, 12), (4, 4)).shape == (2, 3, 4, 4)
