import math

import pytest
import torch
from lerobot.configs.default import DatasetConfig
from lerobot.configs.train import TrainPipelineConfig
from lerobot.policies.factory import make_policy, make_pre_post_processors
from lerobot.scripts.lerobot_train import train

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.inputs import read_prompts
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy


@pytest.fixture
def policy(small_config, keysteps) -> LlakeyCommandPolicy:
    torch.manual_seed(0)
    return LlakeyCommandPolicy(small_config, dataset_meta=keysteps.meta)


def _fit(policy: LlakeyCommandPolicy, batch: dict, steps: int = 60, lr: float = 3e-3) -> float:
    settings = policy.config.get_optimizer_preset()
    settings.lr = lr
    optimizer = settings.build(policy.get_optim_params())
    policy.train()
    for _ in range(steps):
        optimizer.zero_grad()
        loss, _ = policy.forward(batch)
        loss.backward()
        optimizer.step()
        if loss.item() < 0.02:
            break
    policy.eval()
    return loss.item()


def test_learns_what_it_can_see_and_read_and_says_it(policy, keysteps):
    first_and_last_frames = [keysteps[index] for index in (0, 5, 6, 11)]
    batch = torch.utils.data.default_collate(first_and_last_frames)
    assert len(set(batch[schema.INSTRUCTION])) == 4
    policy.config.history_dropout = policy.config.auxiliary_weight = policy.config.shift_pixels = 0
    _fit(policy, batch, steps=150, lr=1e-2)
    _, metrics = policy.forward(batch)
    assert metrics == {"token_accuracy": 1.0, "instruction_accuracy": 1.0, "changed_instruction_accuracy": 1.0}
    policy.config.constrain = False
    assert policy.next_instructions(batch) == batch[schema.INSTRUCTION]


def test_rows_of_a_batch_do_not_depend_on_each_other(policy, batch):
    batch = batch | {schema.TASK: [f"pick up {'the very ' * index}red block" for index in range(6)]}
    together, _ = policy.eval().forward(batch, reduction="none")
    lengths = torch.tensor([len(policy.encoder.answer(text)) for text in batch[schema.INSTRUCTION]])
    together = together * lengths.sum() / 6 / lengths  # each counts by its share of the batch's tokens
    for row in range(6):
        alone, _ = policy.forward({key: value[row : row + 1] for key, value in batch.items()}, reduction="none")
        assert alone[0].item() == pytest.approx(together[row].item(), abs=1e-4)


def test_loss_is_on_the_answer_alone(policy, batch):
    policy.eval()
    inputs, labels = policy.encoder.with_answers(
        torch.rand(6, 3, 3, 32, 32), read_prompts(batch, policy.config), batch[schema.INSTRUCTION]
    )
    assert labels.shape[1] == max(len(policy.encoder.answer(text)) for text in batch[schema.INSTRUCTION])
    assert labels.shape[1] < inputs["input_ids"].shape[1]


def test_training_aid_is_added_in_training_only(policy, batch):
    policy.config.history_dropout = policy.config.shift_pixels = policy.config.colour_jitter = 0
    plain, metrics = policy.eval().forward(batch)
    assert "auxiliary_loss" not in metrics
    aided, metrics = policy.train().forward(batch)
    expected = metrics["instruction_loss"] + policy.config.auxiliary_weight * metrics["auxiliary_loss"]
    assert metrics["instruction_loss"] == pytest.approx(plain.item(), abs=1e-5)
    assert aided.item() == pytest.approx(expected, abs=1e-5)
    without_state = {key: value for key, value in batch.items() if key != schema.STATE}
    assert policy.forward(without_state)[0].item() == pytest.approx(plain.item(), abs=1e-5)


def test_history_reaches_the_model_only_where_it_is_on(small_settings, keysteps, batch):
    changed = batch | {schema.PREVIOUS_INSTRUCTION: ["release the red block"] * 6}
    for history in (0, 1):
        policy = LlakeyCommandPolicy(LlakeyCommandConfig(history=history, **small_settings), dataset_meta=keysteps.meta)
        policy.eval()
        same = torch.equal(policy.forward(batch)[0], policy.forward(changed)[0])
        assert same == (history == 0)


@pytest.fixture
def told(policy, monkeypatch) -> list:
    """The prompts and answers that each forward pass encodes."""
    calls, encode = [], policy.encoder.with_answers

    def record(images, prompts, answers):
        calls.append((prompts, answers))
        return encode(images, prompts, answers)

    monkeypatch.setattr(policy.encoder, "with_answers", record)
    return calls


def test_history_dropout_hides_the_previous_instruction_in_training(policy, batch, told):
    policy.config.history_dropout = 1.0
    policy.train().forward(batch)
    policy.eval().forward(batch)
    hidden, shown = ([prompt.previous for prompt in prompts] for prompts, _ in told)
    assert set(hidden) == {""}
    assert shown == list(batch[schema.PREVIOUS_INSTRUCTION])


def test_order_of_views_matters(small_settings, keysteps, batch):
    torch.manual_seed(0)
    policy = LlakeyCommandPolicy(LlakeyCommandConfig(**small_settings), dataset_meta=keysteps.meta).eval()
    for place, key in enumerate(policy.config.image_keys):
        batch[key] = torch.full_like(batch[key], float(place == 0))  # views that differ as much as they can
    first, _ = policy.forward(batch)
    policy.config.cameras = policy.config.cameras[::-1]
    assert abs(first.item() - policy.forward(batch)[0].item()) > 1e-4  # more than another order of summation


def test_stock_training_saves_a_checkpoint_that_loads_and_speaks(keysteps, small_settings, batch, tmp_path):
    config = TrainPipelineConfig(
        dataset=DatasetConfig(repo_id=keysteps.repo_id, root=str(keysteps.root)),
        policy=LlakeyCommandConfig(**small_settings),
        output_dir=tmp_path / "run",
        steps=3,
        batch_size=4,
        num_workers=0,
        log_freq=1,
        save_freq=3,
        env_eval_freq=0,
    )
    train(config)
    folder = tmp_path / "run/checkpoints/last/pretrained_model"
    loaded = LlakeyCommandPolicy.from_pretrained(folder)
    assert loaded.config.instructions and loaded.config.words
    again = make_policy(loaded.config, ds_meta=keysteps.meta)
    preprocessor, _ = make_pre_post_processors(loaded.config, pretrained_path=str(folder))
    answers = loaded.next_instructions(preprocessor(dict(batch)))
    assert len(answers) == 6 and set(answers) <= set(loaded.config.instructions)
    assert len(again.encoder.tokenizer) == len(loaded.encoder.tokenizer)


def test_saved_and_loaded_policies_say_the_same(policy, batch, tmp_path):
    _fit(policy, batch, steps=3)
    policy.save_pretrained(tmp_path)
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path)
    assert torch.equal(policy.forward(batch)[0], loaded.forward(batch)[0])
    assert policy.next_instructions(batch) == loaded.next_instructions(batch)


def test_pretrained_llava_trains_and_its_checkpoint_stands_alone(tiny_llava, keysteps, batch, tmp_path, monkeypatch):
    config = LlakeyCommandConfig(
        device="cpu", push_to_hub=False, model=str(tiny_llava), dtype="float32", history_dropout=0.0
    )
    policy = LlakeyCommandPolicy(config, dataset_meta=keysteps.meta)
    assert not any(value.requires_grad for value in policy.model.model.vision_tower.parameters())
    before, _ = policy.eval().forward(batch)
    assert _fit(policy, batch, steps=15, lr=1e-2) < before.item()
    policy.save_pretrained(tmp_path / "saved")
    monkeypatch.setattr(
        "lerobot_llakey.policies.command.language_model.load_pretrained",
        lambda name: pytest.fail("loaded again"),
    )
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path / "saved")
    assert torch.equal(policy.forward(batch)[0], loaded.forward(batch)[0])
    answers = loaded.next_instructions(batch)
    assert answers == policy.next_instructions(batch)
    assert set(answers) <= set(config.instructions)


def test_synonyms_reword_training_answers_only(policy, batch, told):
    policy.config.paraphrase_probability = 1.0
    batch[schema.INSTRUCTION] = ["grasp the red block"] * 6
    for _ in range(5):
        policy.train().forward(batch)
    assert {text for _, answers in told for text in answers} == {"grasp the red block", "grab the red block"}
    policy.eval().forward(batch)
    assert set(told[-1][1]) == {"grasp the red block"}


def test_every_parameter_is_trained_once_and_hidden_matrices_by_muon(policy):
    groups = policy.get_optim_params()
    counted = [id(value) for group in groups for value in group["params"]]
    assert sorted(counted) == sorted(id(value) for value in policy.parameters())
    matrices = {id(value) for group in groups if group.get("muon") for value in group["params"]}
    names = {name for name, value in policy.named_parameters() if id(value) in matrices}
    assert any("vision_tower" in name for name in names) and any("language_model" in name for name in names)
    assert not any("embed" in name or "lm_head" in name or "stem" in name for name in names)


def test_it_does_not_act(policy, batch):
    with pytest.raises(NotImplementedError, match=r"--policy.type=llakey"):
        policy.select_action(batch)


def test_bad_input_is_named(policy, batch, small_settings, keysteps):
    without_view = {key: value for key, value in batch.items() if "images.front" not in key}
    with pytest.raises(ValueError, match=r"add observation\.images\.front"):
        policy.next_instructions(without_view)
    without_label = {key: value for key, value in batch.items() if key not in (schema.INSTRUCTION, schema.INDEX)}
    with pytest.raises(ValueError, match=r"'instruction' in the batch"):
        policy.forward(without_label)
    with pytest.raises(ValueError, match="'task' in the batch"):
        policy.next_instructions({key: value for key, value in batch.items() if key != schema.TASK})
    with pytest.raises(ValueError, match=r"without \['observation.images.elbow'\]"):
        make_policy(LlakeyCommandConfig(**small_settings | {"cameras": ["elbow"]}), ds_meta=keysteps.meta)


def test_tells_hands_apart_that_only_their_state_tells_apart(small_settings, keysteps, tmp_path):
    torch.manual_seed(0)
    quiet = {"history_dropout": 0.0, "auxiliary_weight": 0.0, "shift_pixels": 0, "colour_jitter": 0.0}
    config = LlakeyCommandConfig(**small_settings, **quiet, proprioception="pose", history=0)
    policy = LlakeyCommandPolicy(config, dataset_meta=keysteps.meta)
    batch = torch.utils.data.default_collate([keysteps[0]] * 4)
    batch[schema.STATE][:, 2] = torch.tensor([0.1, 0.12, 0.5, 0.52])
    first, second = policy.config.instructions[:2]
    batch[schema.INSTRUCTION] = [first, first, second, second]
    _fit(policy, batch, steps=150, lr=1e-2)
    assert policy.next_instructions(batch) == batch[schema.INSTRUCTION]
    batch[schema.STATE][:, 2] = torch.tensor([0.52, 0.1, 0.5, 0.12])
    assert policy.next_instructions(batch) == [second, first, second, first]
    policy.save_pretrained(tmp_path)
    loaded = LlakeyCommandPolicy.from_pretrained(tmp_path)
    assert schema.STATE in loaded.config.input_features
    assert loaded.next_instructions(batch) == [second, first, second, first]


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        (schema.TASK, "", "words in task, got an empty text"),
        (schema.TASK, None, "a text in task, got None"),
        (schema.INSTRUCTION, math.nan, "a text in instruction, got nan"),
        (schema.INSTRUCTION, "grasp <next goal>", "words alone in instruction, got '<next goal>'"),
        (schema.PREVIOUS_INSTRUCTION, "grasp " * 1700, "at most 1000 characters in previous_instruction"),
        (schema.PREVIOUS_INSTRUCTION, "<image>", "words alone in previous_instruction, got '<image>'"),
    ],
)
def test_texts_that_make_no_sense_are_refused_with_their_row(policy, batch, key, value, said):
    texts = [*batch[key][:1], value, *batch[key][2:]]
    with pytest.raises(LlakeyError, match=rf"Expected {said}.* batch row 1"):
        policy.forward(batch | {key: texts})


def test_poses_of_the_training_aid_are_checked(policy, batch):
    state = batch[schema.STATE].clone()
    state[2, schema.GRIPPER] = math.nan
    with pytest.raises(LlakeyError, match=r"a gripper .* in observation\.state, got \[nan\] in batch row 2"):
        policy.train().forward(batch | {schema.STATE: state})


def test_images_in_bytes_train_as_images_in_floats(policy, batch):
    policy.eval()
    raw = {key: (batch[key] * 255).round().to(torch.uint8) for key in policy.config.image_keys}
    assert policy.forward(batch | raw)[0].item() == pytest.approx(policy.forward(batch)[0].item(), abs=1e-4)
    far = {key: batch[key] * 255 for key in policy.config.image_keys}
    with pytest.raises(LlakeyError, match="colours from 0 to 1 in"):
        policy.answer(batch | far)


def test_known_answers_must_fit_into_the_longest_answer(small_settings, keysteps):
    with pytest.raises(LlakeyError, match=r"max_new_tokens of at least \d+, which '.*' takes, got 3"):
        LlakeyCommandPolicy(LlakeyCommandConfig(max_new_tokens=3, **small_settings), dataset_meta=keysteps.meta)
