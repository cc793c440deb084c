import json
from types import SimpleNamespace

import pytest
import torch

from fakes_action import observation, small_config
from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy

PUBLISHED = {"view_size": 20, "patch_size": 4, "token_width": 32, "transformer_layers": 2, "proprioception": "gripper"}
DESIGNS = pytest.mark.parametrize(
    "settings",
    [
        {"design": "rvt", "stages": 1, "views": ["top", "front", "back", "left", "side"], "rotation_frames": ["view"]},
        {"design": "rvt", "rotation": "sixd", "condition_on": "both"},
        {"design": "rvt2", "rotation": "sequential_bins", "condition_on": "task", "use_timestep": True},
        {"stages": 1, "rotation": "sixd"},
        {"rotation": "sequential_bins", "condition_on": "both", "use_timestep": True},
    ],
    ids=[
        "rvt",
        "rvt-twice",
        "rvt2",
        "small-once",
        "small-in-turn",
    ],
)

# A softmax weighs differences, so what is added to all that it weighs has no say: these gradients are rounding errors,
# and on some processors exactly zero. The layers keep these biases because saved checkpoints have them.
WITHOUT_SAY = ("scores.bias", "match_head.bias", "heatmap.bias")


def untrained(policy):
    """Parameters that no gradient reaches, but for those that have no say."""
    assert all(value.grad.abs().max() < 1e-5 for name, value in policy.named_parameters() if name.endswith(WITHOUT_SAY))
    return [
        name
        for name, value in policy.named_parameters()
        if not name.endswith(WITHOUT_SAY) and (value.grad is None or value.grad.abs().max() < 5e-7)
    ]


def sized(settings):
    return settings if settings.get("design", "small") == "small" else PUBLISHED | settings


def timed_observation(rows, seed=0):
    batch, _, _ = observation(rows, seed)
    return batch | {schema.STEP: torch.arange(float(rows))[:, None]}


def make_policy(**settings):
    torch.manual_seed(0)
    return LlakeyActionPolicy(small_config(**settings))


def without_text(batch):
    return {key: value for key, value in batch.items() if key not in (schema.INSTRUCTION, schema.TASK)}


def test_the_loss_has_its_parts_and_reaches_every_parameter():
    policy = make_policy(heatmap_shrink_steps=10)
    batch, _, _ = observation(rows=3)
    # Films start at zero, so what feeds them gets its first gradient one step later.
    optimiser = torch.optim.SGD(policy.get_optim_params(), lr=1e-2)
    for _ in range(2):
        optimiser.zero_grad()
        loss, figures = policy.forward(batch)
        loss.backward()
        optimiser.step()
    parts = ("coarse_loss", "fine_loss", "rotation_loss", "gripper_loss", "collision_loss")
    assert loss.item() == pytest.approx(sum(figures[part] for part in parts), rel=1e-4)
    assert not untrained(policy)
    assert policy.training_step.item() == 2


def test_it_learns_a_batch_by_heart():
    policy = make_policy(augment_yaw=0.0, heatmap_shrink_steps=20)
    batch, _, _ = observation(rows=4)
    optimiser = torch.optim.AdamW(policy.get_optim_params(), lr=3e-3)
    for _ in range(60):
        loss, _ = policy.forward(batch)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    action = policy.select_action(batch)
    error = (action[:, schema.POSITION] - batch[schema.ACTION][:, schema.POSITION]).norm(dim=1)
    assert error.max() < 0.02
    assert (action[:, 7:] == batch[schema.ACTION][:, 7:]).all()


def test_actions_follow_the_contract():
    policy = make_policy()
    batch, _, _ = observation(rows=2)
    action = policy.select_action(batch)
    assert action.shape == (2, schema.ACTION_DIM)
    assert action.dtype == torch.float32
    workspace = torch.tensor(schema.WORKSPACE)
    assert ((action[:, :3] > workspace[:, 0] - 0.13) & (action[:, :3] < workspace[:, 1] + 0.13)).all()
    assert torch.allclose(action[:, schema.QUATERNION].norm(dim=1), torch.ones(2), atol=1e-5)
    assert (action[:, 6] >= 0).all()
    assert set(action[:, 7:].flatten().tolist()) <= {0.0, 1.0}
    assert policy.predict_action_chunk(batch).shape == (2, 1, schema.ACTION_DIM)


def test_deciding_is_repeatable_and_saved_policies_decide_alike(tmp_path):
    policy = make_policy()
    policy.forward(observation(rows=2)[0])
    batch, _, _ = observation(rows=2, seed=1)
    action = policy.select_action(batch)
    policy.save_pretrained(tmp_path)
    loaded = LlakeyActionPolicy.from_pretrained(tmp_path)
    assert torch.equal(policy.select_action(batch), action)
    assert torch.equal(loaded.select_action(batch), action)
    assert loaded.training_step.item() == 1
    assert json.loads((tmp_path / "config.json").read_text())["type"] == "llakey_action"


def test_missing_text_is_refused():
    batch, _, _ = observation(rows=2)
    with pytest.raises(LlakeyError, match=r"Expected 'instruction' in the batch, got .*, task; give an instruction"):
        make_policy().select_action(without_text(batch) | {schema.TASK: batch[schema.TASK]})
    with pytest.raises(LlakeyError, match="Expected 'task' in the batch, got"):
        make_policy(condition_on="task").select_action(without_text(batch))
    with pytest.raises(LlakeyError, match="got 1"):
        make_policy().select_action(without_text(batch) | {schema.INSTRUCTION: "grasp"})


def test_a_target_outside_the_workspace_names_its_row():
    batch, _, _ = observation(rows=2)
    batch[schema.ACTION][1, 0] = 1.4
    with pytest.raises(ValueError, match=r"batch row 1; widen policy\.workspace"):
        make_policy().forward(batch)


def test_rows_can_be_weighted():
    policy = make_policy().eval()
    batch, _, _ = observation(rows=3)
    each, _ = policy.forward(batch, reduction="none")
    assert each.shape == (3,)
    weighted, _ = policy.forward(batch | {"observation.sample_weight": torch.tensor([[2.0], [0.0], [1.0]])})
    assert torch.allclose(weighted, (each * torch.tensor([2.0, 0.0, 1.0])).mean())


def test_without_state_the_hand_is_not_looked_at():
    policy = make_policy(proprioception="none")
    batch, _, _ = observation(rows=1)
    del batch[schema.STATE]
    assert policy.select_action(batch).isfinite().all()


def test_bfloat16_stays_close_to_float32():
    policy = make_policy().eval()
    batch, _, _ = observation(rows=2)
    exact, _ = policy.forward(batch)
    policy.config.dtype = "bfloat16"
    rough, _ = policy.forward(batch)
    assert exact.item() == pytest.approx(rough.item(), rel=0.02)


def test_a_dataset_without_instructions_is_refused_unless_the_task_steers():
    meta = SimpleNamespace(
        features={key: value for key, value in schema.dataset_features().items() if key != schema.INSTRUCTION}
    )

    with pytest.raises(ValueError, match="without instruction columns"):
        LlakeyActionPolicy(small_config(), dataset_meta=meta)
    LlakeyActionPolicy(small_config(condition_on="task"), dataset_meta=meta)


@DESIGNS
def test_every_design_trains_all_it_has_and_decides_alike_once_saved(settings, tmp_path):
    policy = make_policy(**sized(settings))
    batch = timed_observation(rows=2)
    optimiser = torch.optim.SGD(policy.get_optim_params(), lr=1e-2)
    for _ in range(2):
        optimiser.zero_grad()
        loss, figures = policy.forward(batch)
        loss.backward()
        optimiser.step()
    assert loss.item() == pytest.approx(sum(value for key, value in figures.items() if "loss" in key), rel=1e-4)
    assert ("fine_loss" in figures) == (settings.get("stages", 2) == 2)
    assert not untrained(policy)
    action = policy.select_action(batch)
    assert action.shape == (2, schema.ACTION_DIM) and action.isfinite().all()
    policy.save_pretrained(tmp_path)
    assert torch.equal(LlakeyActionPolicy.from_pretrained(tmp_path).select_action(batch), action)


@DESIGNS
def test_every_design_runs_in_bfloat16(settings):
    policy = make_policy(**sized(settings)).eval()
    batch = timed_observation(rows=2)
    exact, _ = policy.forward(batch)
    policy.config.dtype = "bfloat16"
    rough, _ = policy.forward(batch)
    rough.backward()
    assert exact.item() == pytest.approx(rough.item(), rel=0.02)
    assert policy.select_action(batch).dtype == torch.float32


def test_each_conditioning_reaches_the_decision():
    batch = timed_observation(rows=1)
    policy = make_policy(condition_on="both", use_timestep=True)
    # Films start at zero: after a step of training everything has a say.
    optimiser = torch.optim.SGD(policy.get_optim_params(), lr=1e-1)
    policy.forward(batch)[0].backward()
    optimiser.step()
    policy.eval()
    plain = policy.forward(batch)[0].item()
    changes = {schema.TASK: ["close the jar"], schema.INSTRUCTION: ["release it"], schema.STEP: torch.tensor([[9.0]])}
    for key, value in changes.items():
        assert abs(policy.forward(batch | {key: value})[0].item() - plain) > 1e-4, key


def test_the_timestep_is_asked_for_only_where_it_is_used():
    batch = timed_observation(rows=1)
    del batch[schema.STEP]
    make_policy().select_action(batch)
    with pytest.raises(ValueError, match=r"Expected observation\.step .* got none"):
        make_policy(use_timestep=True).select_action(batch)


@pytest.mark.parametrize(
    "settings",
    [
        {"design": "rvt", "stages": 1, "view_size": 24, "patch_size": 3},
        {"design": "rvt2", "rotation": "sequential_bins", "view_size": 32, "patch_size": 8, "crop_noise": 0.02},
    ],
    ids=["rvt", "rvt2"],
)
def test_published_designs_learn_a_batch_by_heart(settings):
    plain = {"augment_yaw": 0.0, "augment_translation": 0.0, "heatmap_shrink_steps": 30}
    policy = make_policy(**(PUBLISHED | plain | settings))
    batch, _, _ = observation(rows=2)
    optimiser = torch.optim.AdamW(policy.get_optim_params(), lr=5e-3)
    for _ in range(60):
        loss, _ = policy.forward(batch)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    action = policy.select_action(batch)
    error = (action - batch[schema.ACTION])[:, schema.POSITION].norm(dim=1)
    assert error.max() < 1 / policy.config.view_size
    assert torch.allclose(action[:, 3:], batch[schema.ACTION][:, 3:], atol=1e-5)


@pytest.mark.parametrize("setting", ["colour_jitter", "rotation_blur"])
def test_clouds_and_the_told_turn_are_varied_in_training_only(setting):
    batch, _, _ = observation(rows=2)
    plain = {"augment_translation": 0.0, "augment_yaw": 0.0, "crop_noise": 0.0, "paraphrase_probability": 0.0}
    losses = {}
    for share in (0.0, 0.5):
        torch.manual_seed(0)
        policy = LlakeyActionPolicy(small_config(**plain, **{setting: share}))
        losses[share] = [policy.train(mode)(batch)[0].item() for mode in (True, False)]
    assert losses[0.0][0] != losses[0.5][0]
    assert losses[0.0][1] == losses[0.5][1]


FLAT = [[0.0, 1.2], [-0.5, 0.5], [-0.05, 0.25]]


@pytest.mark.parametrize("workspace", [FLAT, [[0.2, 0.8], [-0.6, 0.6], [-0.05, 0.95]]])
def test_no_target_lies_outside_its_own_crop_whatever_the_workspace(workspace):
    policy = make_policy(workspace=workspace, crop_size=0.1, crop_noise=0.04)
    low, high = torch.tensor(workspace).T
    target = policy.cube.to_unit(low + torch.rand(2000, 3) * (high - low))
    corner, extent = policy.cube.crop(target + policy._crop_noise(target), policy.config.crop_size)
    local = (target - corner) / extent
    assert local.min() > 0 and local.max() < 1
    assert (local - 0.5).abs().max() * 0.1 > 0.03  # metres: the noise is as wide as asked for along some axis
    assert ((local - 0.5).abs().amax(dim=0) * 0.1 > 0.03).all()


def test_a_flat_workspace_trains_and_decides():
    policy = make_policy(workspace=FLAT)
    batch, _, _ = observation(rows=2)
    loss, _ = policy.forward(batch)
    loss.backward()
    action = policy.select_action(batch)
    assert action.isfinite().all() and (action[:, :3].abs() < 2).all()


@pytest.mark.parametrize("key", [schema.STATE, schema.ACTION])
@pytest.mark.parametrize("value", [0.0, float("nan")])
def test_a_pose_that_is_none_is_refused_before_it_is_moved(key, value):
    batch, _, _ = observation(rows=2)
    batch[key][1, schema.QUATERNION] = value
    with pytest.raises(ValueError, match=rf"a unit quaternion xyzw in {key}, got .* in batch row 1"):
        make_policy(augment_yaw=20.0).forward(batch)


def test_weights_that_are_not_finite_neither_act_nor_train():
    policy = make_policy()
    batch, _, _ = observation(rows=2)
    with torch.no_grad():
        policy.fine.network.head_norm.weight.fill_(float("nan"))
    with pytest.raises(ValueError, match="answer with finite numbers"):
        policy.select_action(batch)
    with pytest.raises(ValueError, match="a finite training loss, got nan"):
        policy.train().forward(batch)


def test_bytes_and_floats_of_an_image_are_decided_on_alike():
    policy = make_policy().eval()
    batch, _, _ = observation(rows=2)
    action = policy.select_action(batch)
    for camera in schema.CAMERAS:
        batch[schema.image_key(camera)] = (batch[schema.image_key(camera)] * 255).round().to(torch.uint8)
    assert torch.allclose(policy.select_action(batch), action, atol=1e-5)
