"""What is kept of a decision is what the policy saw and decided."""

from pathlib import Path

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import make_policy
from lerobot.utils.collate import lerobot_collate_fn

from fakes import fake_keysteps
from fakes_action import small_config
from lerobot_llakey import schema
from lerobot_llakey.inspection.trace import Trace, trace
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return fake_keysteps(tmp_path_factory.mktemp("keysteps") / "data", episodes=1, frames=2)


def policy(stages: int) -> LlakeyActionPolicy:
    torch.manual_seed(0)
    return LlakeyActionPolicy(small_config(stages=stages)).eval()


@pytest.mark.parametrize("stages", [1, 2])
def test_the_stages_and_the_decision_are_kept(dataset: LeRobotDataset, stages: int) -> None:
    actor = policy(stages)
    seen = trace(actor, dataset, 1)
    assert [stage.name for stage in seen.stages] == ["coarse", "fine"][:stages]
    assert torch.equal(seen.true, dataset[1][schema.ACTION])
    assert torch.equal(seen.predicted, actor.select_action(lerobot_collate_fn([dataset[1]]))[0])
    for stage in seen.stages:
        assert stage.images.shape == (3, 64, 64, 3)
        assert torch.allclose(stage.heatmap.sum(dim=(1, 2)), torch.ones(3), atol=1e-4)
    assert seen.instruction == "grasp the " + seen.task.split()[3] + " block"


def test_the_decision_is_where_the_last_stage_is_hottest(dataset: LeRobotDataset) -> None:
    seen = trace(policy(2), dataset, 0)
    fine = seen.stages[-1]
    place = fine.local(seen.predicted[schema.POSITION])
    assert ((place > 0) & (place < 1)).all()
    assert fine.extent.tolist() == pytest.approx([policy(2).config.crop_size] * 3, abs=1e-4)


def test_nothing_stays_attached_to_the_policy(dataset: LeRobotDataset) -> None:
    actor = policy(2)
    first = trace(actor, dataset, 0)
    trace(actor, dataset, 1)
    assert len(first.stages) == 2
    assert not actor.coarse._forward_hooks


def test_the_action_part_of_a_hierarchical_policy_is_looked_into(dataset: LeRobotDataset) -> None:
    whole = torch.nn.Module()
    whole.action = policy(1)
    assert torch.equal(trace(whole, dataset, 0).predicted, trace(whole.action, dataset, 0).predicted)


def test_the_command_part_is_asked_what_it_would_say(dataset: LeRobotDataset) -> None:
    sizes = {"image_size": 32, "patch_size": 16, "vision_width": 16, "vision_layers": 1, "vision_heads": 2}
    words = {"text_width": 32, "text_layers": 1, "text_heads": 2, "dtype": "float32", "device": "cpu"}
    config = LlakeyConfig(
        command=LlakeyCommandConfig(**sizes, **words), action=small_config(stages=1), device="cpu", push_to_hub=False
    )
    whole = make_policy(config, ds_meta=dataset.meta).eval()
    seen = trace(whole, dataset, 0)
    assert seen.said == whole.command.next_instructions(lerobot_collate_fn([dataset[0]]))[0]
    assert trace(whole.action, dataset, 0).said == ""


def test_errors_are_told_in_centimetres_and_degrees() -> None:
    true = torch.tensor([0.5, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    predicted = torch.tensor([0.5, 0.03, 0.14, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    nothing = torch.zeros(0, 3)
    errors = Trace("", "", {}, nothing, nothing, [], predicted, true).errors()
    assert errors["centimetres"] == pytest.approx(5.0, abs=1e-3)
    assert errors["degrees"] == pytest.approx(0.0, abs=0.1), "half a turn of a parallel gripper is no error"
    assert (errors["gripper"], errors["collision"]) == (0.0, 1.0)


def test_another_policy_and_a_frame_that_is_not_there_are_refused(dataset: LeRobotDataset, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="got Linear"):
        trace(torch.nn.Linear(1, 1), dataset, 0)
    with pytest.raises(ValueError, match=r"index in \[0, 2\), got 2"):
        trace(policy(1), dataset, 2)
