import pytest
from torch import nn

from fakes_models import TINY
from lerobot_llakey.policies.command.pretrained.freezing import part_of, train_parts


def _trained(model) -> set[str]:
    return {part_of(name) for name, value in model.named_parameters() if value.requires_grad}


@pytest.mark.parametrize("family", TINY)
@pytest.mark.parametrize("parts", [{"projector", "language"}, {"vision", "projector"}, {"language"}])
def test_the_parts_of_every_family_are_told_apart(family, parts):
    model, _ = TINY[family]()
    train_parts(model, sorted(parts))
    assert _trained(model) == parts
    towers = ("vision_tower", "vision_model", "visual.blocks")
    for name, value in model.named_parameters():
        if any(tower in name for tower in towers):
            assert value.requires_grad == ("vision" in parts), name


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("model.visual.merger.mlp.0.weight", "projector"),
        ("model.visual.deepstack_merger_list.0.norm.weight", "projector"),
        ("model.visual.blocks.0.norm1.weight", "vision"),
        ("model.image_newline", "projector"),
        ("model.language_model.layers.0.mlp.up_proj.weight", "language"),
        ("lm_head.weight", "language"),
    ],
)
def test_names_tell_the_part(name, part):
    assert part_of(name) == part


def test_a_model_of_unknown_parts_is_named_unless_all_of_it_is_trained():
    model = nn.Sequential(nn.Linear(2, 2))
    train_parts(model, ["vision", "projector", "language"])
    with pytest.raises(ValueError, match=r"got none that is known as projector and vision; set train="):
        train_parts(model, ["language"])
