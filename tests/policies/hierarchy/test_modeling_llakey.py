from pathlib import Path
from types import SimpleNamespace

import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.policies.pretrained import PreTrainedPolicy
from safetensors.torch import load_file, save_file

from lerobot_llakey import schema
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy


def _says(policy: LlakeyPolicy, monkeypatch: pytest.MonkeyPatch, *steps: list[str]) -> list[list[str]]:
    """Make the command policy say given texts, step by step, and record the previous instructions it was told."""
    told: list[list[str]] = []
    script = iter(steps)

    def answer(batch: dict, **_) -> list[SimpleNamespace]:
        told.append(list(batch[schema.PREVIOUS_INSTRUCTION]))
        return [SimpleNamespace(text=text, likelihood=0.5) for text in next(script)]

    monkeypatch.setattr(policy.command, "answer", answer, raising=False)
    return told


def _read(policy: LlakeyPolicy, monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Record the instructions that reach the action policy."""
    read: list[list[str]] = []
    select = policy.action.select_action

    def select_action(batch: dict) -> torch.Tensor:
        read.append(list(batch[schema.INSTRUCTION]))
        return select(batch)

    monkeypatch.setattr(policy.action, "select_action", select_action)
    return read


def test_acts_with_valid_keyframes_and_says_what_it_does(make_tiny, observation) -> None:
    policy = make_tiny()
    actions = policy.select_action(observation)
    assert actions.shape == (3, schema.ACTION_DIM)
    assert torch.allclose(actions[:, schema.QUATERNION].norm(dim=1), torch.ones(3), atol=1e-6)
    assert len(policy.last_instructions) == 3
    for text, action in zip(policy.last_instructions, actions, strict=True):
        implied = BASIC_GRAMMAR.gripper_implied(text)
        assert implied is None or action[schema.GRIPPER] == float(implied)


def test_each_row_remembers_its_own_previous_instruction(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny()
    said = [["grasp the lid", "nonsense", "grab the jar"], ["raise the robotic arm", "release the lid", "mumble"]]
    told, read = _says(policy, monkeypatch, *said, ["grasp the lid"] * 3), _read(policy, monkeypatch)
    for _ in range(3):
        policy.select_action(observation)
    assert told[0] == ["", "", ""]
    assert told[1] == ["grasp the lid", "raise the robotic arm", "grasp the jar"]
    assert told[2] == read[1] == ["raise the robotic arm", "release the lid", "grasp the jar"]
    assert [row.unparsable for row in policy.supervisors] == [0, 1, 1]


def test_the_words_override_the_gripper(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny()
    _says(policy, monkeypatch, ["grasp the lid", "release the lid", "raise the robotic arm"])
    proposed = torch.tensor([[0.4, 0, 0.3, 1, 0, 0, 0, 1, 0], [0.4, 0, 0.3, 1, 0, 0, 0, 0, 0]] * 2)[:3]
    monkeypatch.setattr(policy.action, "select_action", lambda batch: proposed)
    assert policy.select_action(observation)[:, schema.GRIPPER].tolist() == [0.0, 1.0, 1.0]


def test_stalled_rows_make_random_moves_and_others_do_not(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny(repeat_threshold=1, random_move_probability=1.0, random_move_radius=0.05)
    steps = [["grasp the lid", f"grasp the {colour} block", "grasp the jar"] for colour in ("red", "blue", "green")]
    _says(policy, monkeypatch, *steps)
    actions = [policy.select_action(observation) for _ in range(3)]
    assert [row.random_moves for row in policy.supervisors] == [1, 0, 1]
    distance = (actions[2][:, :3] - observation[schema.STATE][:, :3]).norm(dim=1)
    assert (distance[[0, 2]] <= 0.05).all()


def test_seed_fixes_the_random_moves(make_tiny, observation) -> None:
    runs = []
    observation[schema.STATE][:, 8] = torch.tensor([0.1, 0.2, 0.1])  # three episodes of which two are the same
    for seed in (1, 1, 2):
        policy = make_tiny(commander="oracle", repeat_threshold=0, random_move_probability=1.0, seed=seed)
        batch = observation | {schema.ORACLE_INSTRUCTION: ["pull the lid out"] * 3}
        runs.append(torch.stack([policy.select_action(batch) for _ in range(2)]))
    assert torch.equal(runs[0], runs[1])
    assert not torch.equal(runs[0], runs[2])
    assert not torch.equal(runs[0][1, 0], runs[0][1, 1])
    assert torch.equal(runs[0][1, 0], runs[0][1, 2])


def test_a_new_seed_counts_from_the_next_episode_on(make_tiny, observation) -> None:
    policy = make_tiny(commander="oracle", repeat_threshold=0, random_move_probability=1.0)
    batch = observation | {schema.ORACLE_INSTRUCTION: ["pull the lid out"] * 3}
    runs = []
    for seed in (1, 2, 1):
        policy.reseed(seed)
        policy.reset()
        runs.append(torch.stack([policy.select_action(batch) for _ in range(2)]))
    assert torch.equal(runs[0], runs[2]) and not torch.equal(runs[0], runs[1])


def test_the_oracle_commands_in_place_of_the_policy(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny(commander="oracle")
    read = _read(policy, monkeypatch)
    said = ["grasp the lid", "raise the robotic arm", ""]
    policy.select_action(observation | {schema.ORACLE_INSTRUCTION: said})
    assert policy.command is None
    assert read == [["grasp the lid", "raise the robotic arm", "raise the robotic arm"]]
    with pytest.raises(ValueError, match=r"Expected 'observation.oracle_instruction. .*--env.oracle_instructions=true"):
        policy.select_action(observation)


def test_the_task_itself_can_be_the_instruction(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny(commander="task")
    read = _read(policy, monkeypatch)
    policy.select_action(observation)
    assert read == [observation[schema.TASK]] == [policy.last_instructions]


def test_a_list_commands_one_a_step(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny(commander="list", instructions=["grab the lid", "raise the robotic arm"])
    read = _read(policy, monkeypatch)
    for _ in range(3):
        policy.select_action(observation)
    assert policy.command is None
    assert [step[0] for step in read] == ["grasp the lid", "raise the robotic arm", "raise the robotic arm"]
    policy.reset()
    policy.select_action(observation)
    assert read[-1] == ["grasp the lid"] * 3


def test_a_person_corrects_and_changes_the_goal(make_tiny, observation, monkeypatch) -> None:
    policy = make_tiny()
    corrections = policy.loop.corrections
    read, goals = _read(policy, monkeypatch), []
    answer = policy.command.answer
    monkeypatch.setattr(policy.command, "answer", lambda batch, *_: goals.append(batch[schema.TASK]) or answer(batch))
    corrections.say(1, "grab the lid")
    corrections.change_task(2, "stack the wine")
    policy.select_action(observation)
    assert read[0][1] == "grasp the lid"
    assert [step.source for row in policy.log for step in row] == ["policy", "person", "policy"]
    assert goals == [[observation[schema.TASK][0], "stack the wine"]]
    assert policy.log[2][0].task == "stack the wine"
    policy.reset()
    policy.select_action(observation)
    assert goals[-1] == list(observation[schema.TASK])


def test_a_batch_of_another_size_needs_a_reset(make_tiny, observation) -> None:
    policy = make_tiny(commander="task")
    policy.select_action(observation)
    smaller = {key: value[:2] for key, value in observation.items()}
    with pytest.raises(ValueError, match="batch of 3 rows as in the step before, got 2; call reset"):
        policy.select_action(smaller)
    policy.reset()
    assert policy.last_instructions == []
    assert policy.select_action(smaller).shape == (2, 9)


def test_a_camera_with_fewer_rows_than_the_state_is_named(make_tiny, observation) -> None:
    key = schema.image_key("front")
    observation[key] = observation[key][:1]
    with pytest.raises(ValueError, match=rf"{key} of shape \(3, channels, height, width\), got \(1, 3, 32, 32\)"):
        make_tiny().select_action(observation)


def test_missing_state_is_named(make_tiny, observation) -> None:
    del observation[schema.STATE]
    with pytest.raises(ValueError, match=r"Expected observation.state in the batch"):
        make_tiny().select_action(observation)


def test_training_adds_up_both_losses(make_tiny, training_batch) -> None:
    policy = make_tiny()
    loss, metrics = policy.forward(training_batch)
    assert loss.item() == pytest.approx(metrics["command_loss"] + metrics["action_loss"], rel=1e-5)
    assert {"command_instruction_accuracy", "action_coarse_loss"} <= metrics.keys()
    assert all(isinstance(value, float) for value in metrics.values())
    loss.backward()
    for part in (policy.command, policy.action):
        assert any(p.grad is not None and p.grad.abs().sum() > 0 for p in part.parameters())
    apart, _ = policy.forward(training_batch, reduction="none")
    assert apart.shape == (6,)


@pytest.mark.parametrize("part", ["command", "action"])
def test_one_part_can_be_trained_alone(part: str, make_tiny, training_batch) -> None:
    policy = make_tiny(**{f"train_{other}": other == part for other in ("command", "action")})
    loss, metrics = policy.forward(training_batch)
    assert loss.item() == pytest.approx(metrics[f"{part}_loss"])
    trained = {id(p) for group in policy.get_optim_params() for p in group["params"]}
    assert trained == {id(p) for p in getattr(policy, part).parameters() if p.requires_grad}
    frozen = {"command": policy.action, "action": policy.command}[part]
    assert not any(p.requires_grad for p in frozen.parameters())


def test_learning_rates_are_the_parts_own_times_their_multipliers(make_tiny) -> None:
    policy = make_tiny(command_lr_multiplier=0.5, action_lr_multiplier=2.0)
    optimizer = policy.config.get_optimizer_preset().build(policy.get_optim_params())
    rates = {id(p): group["lr"] for group in optimizer.param_groups for p in group["params"]}
    assert {rates[id(p)] for p in policy.command.parameters() if p.requires_grad} == {
        0.5 * policy.config.command.get_optimizer_preset().lr
    }
    assert {rates[id(p)] for p in policy.action.parameters()} == {2.0 * policy.config.action.optimizer_lr}
    decays = {group["weight_decay"] for group in optimizer.param_groups}
    assert decays == {0.0, policy.config.command.optimizer_weight_decay, policy.config.action.optimizer_weight_decay}


def _same(first: PreTrainedPolicy, second: PreTrainedPolicy) -> bool:
    weights, others = first.state_dict(), second.state_dict()
    return weights.keys() == others.keys() and all(torch.equal(weights[key], others[key]) for key in weights)


def test_a_saved_checkpoint_holds_everything(make_tiny, saved: Path, observation) -> None:
    processors = ["policy_postprocessor.json", "policy_preprocessor.json"]
    assert sorted(file.name for file in saved.iterdir()) == ["config.json", "model.safetensors", *processors]
    policy, loaded = make_tiny(), LlakeyPolicy.from_pretrained(saved)
    assert _same(policy, loaded)
    assert loaded.command.config.instructions == policy.command.config.instructions != []
    assert torch.equal(policy.select_action(observation), loaded.select_action(observation))
    assert policy.last_instructions == loaded.last_instructions


def test_a_checkpoint_on_the_hub_is_fetched_whole(saved: Path, monkeypatch) -> None:
    asked = []

    def snapshot_download(repo_id: str, **options) -> str:
        asked.append((repo_id, options))
        return str(saved)

    monkeypatch.setattr("lerobot_llakey.saved.folder.snapshot_download", snapshot_download)
    loaded = LlakeyPolicy.from_pretrained("someone/llakey", revision="v1")
    assert [(name, options["revision"]) for name, options in asked] == [("someone/llakey", "v1")]
    assert _same(loaded, LlakeyPolicy.from_pretrained(saved))


def test_is_composed_of_two_trained_parts(make_tiny, observation, tmp_path: Path) -> None:
    trained = make_tiny()
    trained.command.save_pretrained(tmp_path / "command")
    trained.action.save_pretrained(tmp_path / "action")
    paths = {"command_path": str(tmp_path / "command"), "action_path": str(tmp_path / "action")}
    composed = make_tiny(**paths)
    assert _same(trained, composed)
    assert composed.config.command_path is composed.config.action_path is None
    composed.save_pretrained(tmp_path / "both")
    assert _same(trained, LlakeyPolicy.from_pretrained(tmp_path / "both"))


def test_a_path_replaces_one_part_of_a_checkpoint(make_tiny, saved: Path, tmp_path: Path) -> None:
    other = make_tiny()
    with torch.no_grad():
        for parameter in other.action.parameters():
            parameter.add_(1.0)
    other.action.save_pretrained(tmp_path / "action")
    config = PreTrainedConfig.from_pretrained(saved, cli_overrides=[f"--action_path={tmp_path / 'action'}"])
    loaded = LlakeyPolicy.from_pretrained(saved, config=config)
    assert _same(loaded.action, other.action)
    assert _same(loaded.command, LlakeyPolicy.from_pretrained(saved).command)


def test_without_a_command_policy_its_weights_are_left_out(saved: Path) -> None:
    config = PreTrainedConfig.from_pretrained(saved, cli_overrides=["--commander=oracle"])
    loaded = LlakeyPolicy.from_pretrained(saved, config=config)
    assert loaded.command is None
    assert _same(loaded.action, LlakeyPolicy.from_pretrained(saved).action)


def test_checkpoints_of_another_kind_are_refused(make_tiny, saved: Path, tmp_path: Path) -> None:
    make_tiny().action.save_pretrained(tmp_path / "action")
    with pytest.raises(ValueError, match=r"type 'llakey' at .* of type 'llakey_action': a checkpoint of another kind"):
        LlakeyPolicy.from_pretrained(tmp_path / "action")
    with pytest.raises(ValueError, match=r"type 'llakey_command' at .* 'llakey_action': a checkpoint of another kind"):
        make_tiny(command_path=str(tmp_path / "action"))
    config = PreTrainedConfig.from_pretrained(saved)
    with pytest.raises(ValueError, match="'llakey_action': a checkpoint of another kind"):
        LlakeyPolicy.from_pretrained(tmp_path / "action", config=config)
    with pytest.raises(FileNotFoundError, match="where none was found; check the path"):
        make_tiny(command_path=str(tmp_path / "nowhere"))


def test_weights_that_do_not_fit_the_settings_are_refused(make_tiny, saved: Path, tmp_path: Path) -> None:
    config = PreTrainedConfig.from_pretrained(saved, cli_overrides=["--action.text_buckets=128"])
    with pytest.raises(ValueError, match="a checkpoint of another kind"):
        LlakeyPolicy.from_pretrained(saved, config=config)
    save_file({"other.weight": torch.zeros(1)}, saved / "model.safetensors")
    with pytest.raises(ValueError, match=r"a checkpoint of another kind: .* missing"):
        LlakeyPolicy.from_pretrained(saved)
    make_tiny().action.save_pretrained(tmp_path / "action")
    file = tmp_path / "action" / "model.safetensors"
    save_file(dict(list(load_file(file).items())[1:]), file)
    with pytest.raises(ValueError, match="a checkpoint of another kind"):
        make_tiny(action_path=str(tmp_path / "action"))
