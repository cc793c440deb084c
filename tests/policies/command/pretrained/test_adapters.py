import json
import re

import pytest
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.configs.default import DatasetConfig, PeftConfig
from lerobot.configs.train import TrainPipelineConfig
from lerobot.policies.factory import make_policy
from lerobot.scripts.lerobot_train import train

from fakes_models import TINY, write_tiny
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.pretrained.adapters import adapter_base, adapter_targets
from lerobot_llakey.policies.hierarchy.parts import load_part

peft = pytest.importorskip("peft")


def _learn_with_lora(config: LlakeyCommandConfig, keysteps, folder):
    """Two steps of ``lerobot-train --peft...``; the checkpoint's folder."""
    run = TrainPipelineConfig(
        dataset=DatasetConfig(repo_id=keysteps.repo_id, root=str(keysteps.root)),
        policy=config,
        peft=PeftConfig(r=4, lora_alpha=8),
        output_dir=folder,
        steps=2,
        batch_size=4,
        num_workers=0,
        log_freq=1,
        save_freq=2,
        env_eval_freq=0,
    )
    config.optimizer_lr, config.scheduler_warmup_steps = 3e-2, 0
    train(run)
    return folder / "checkpoints/last/pretrained_model"


def _learn_quickly_with_lora(policy: LlakeyCommandPolicy, batch: dict, folder):
    """The same without LeRobot's script; saves what the script saves."""
    wrapped = policy.wrap_with_peft(peft_cli_overrides={"method_type": "LORA", "r": 4})
    optimizer = torch.optim.AdamW(wrapped.get_optim_params(), lr=3e-2)
    for _ in range(2):
        optimizer.zero_grad()
        wrapped.train().forward(batch)[0].backward()
        optimizer.step()
    wrapped.save_pretrained(folder)
    wrapped.config.save_pretrained(folder)
    return folder


@pytest.mark.parametrize("family", TINY)
def test_adapters_go_into_the_language_models_linear_layers_of_every_family(family):
    model, _ = TINY[family]()
    targets = adapter_targets(model, ["projector", "language"], stop_id=7)
    matched = {n for n, _ in model.named_modules() if re.fullmatch(targets["target_modules"], f"model.{n}")}
    linear = {
        name
        for name, module in model.named_modules()
        if isinstance(module, torch.nn.Linear) and re.search(r"language_model|text_model", name)
    }
    linear -= {name for name in linear if "vision" in name}
    assert matched == linear and matched
    assert len(targets["modules_to_save"]) == 1 and targets["trainable_token_indices"] == {"lm_head": [7]}


def test_the_vision_tower_gets_adapters_where_it_is_trained():
    model, _ = TINY["llava"]()
    pattern = adapter_targets(model, ["vision"], 0)["target_modules"]
    matched = {name for name, _ in model.named_modules() if re.fullmatch(pattern, f"model.{name}")}
    assert matched and all("vision_tower" in name for name in matched)


def test_other_methods_train_the_whole_output_layer():
    model, _ = TINY["llava"]()
    targets = adapter_targets(model, ["projector", "language"], 0, "LOHA")
    assert targets["modules_to_save"] == ["multi_modal_projector", "lm_head"]
    assert "trainable_token_indices" not in targets


def test_a_projector_alone_needs_no_adapters():
    model, _ = TINY["llava"]()
    with pytest.raises(ValueError, match=r"got train=\['projector'\]"):
        adapter_targets(model, ["projector"], 0)


@pytest.mark.parametrize(("family", "by_script"), [("llava", True), ("idefics3", False)])
def test_lora_on_a_model_by_name_is_trained_loaded_and_merged(family, by_script, keysteps, batch, tmp_path):
    base = write_tiny(family, tmp_path / "base")
    config = LlakeyCommandConfig(device="cpu", push_to_hub=False, model=str(base), dtype="float32")
    if by_script:
        folder = _learn_with_lora(config, keysteps, tmp_path / "run")
    else:
        folder = _learn_quickly_with_lora(
            LlakeyCommandPolicy(config, dataset_meta=keysteps.meta), batch, tmp_path / "a"
        )
    assert adapter_base(folder) == str(base)
    assert not (folder / "model.safetensors").exists()

    saved = PreTrainedConfig.from_pretrained(folder)
    saved.pretrained_path = folder
    assert saved.use_peft
    apart = make_policy(saved, ds_meta=keysteps.meta).eval()
    assert isinstance(apart, peft.PeftModel)
    merged = LlakeyCommandPolicy.from_pretrained(folder)
    assert type(merged) is LlakeyCommandPolicy and not merged.config.use_peft
    fresh = LlakeyCommandConfig(device="cpu", model=str(base), dtype="float32", cameras=merged.config.cameras)
    untrained = LlakeyCommandPolicy(fresh).eval()

    losses = [policy.forward(batch)[0].item() for policy in (apart, merged, untrained)]
    assert losses[0] == pytest.approx(losses[1], abs=1e-4)
    assert abs(losses[0] - losses[2]) > 0.01
    assert apart.next_instructions(batch) == merged.next_instructions(batch)
    stop = merged.encoder.stop_id
    rows = [policy.model.lm_head.weight[stop] for policy in (merged, untrained)]
    assert not torch.allclose(*rows, atol=1e-4)

    merged.save_pretrained(tmp_path / "whole")
    whole = LlakeyCommandPolicy.from_pretrained(tmp_path / "whole")
    assert torch.equal(whole.forward(batch)[0], merged.forward(batch)[0])


def test_lora_on_a_checkpoint_of_the_small_model(keysteps, batch, small_config, tmp_path):
    LlakeyCommandPolicy(small_config, dataset_meta=keysteps.meta).save_pretrained(tmp_path / "base")
    base = LlakeyCommandPolicy.from_pretrained(tmp_path / "base")
    base.config.pretrained_path = tmp_path / "base"
    folder = _learn_quickly_with_lora(base, batch, tmp_path / "adapter")
    assert adapter_base(folder) == str(tmp_path / "base")
    saved = PreTrainedConfig.from_pretrained(folder)
    saved.pretrained_path = folder
    apart, merged = make_policy(saved, ds_meta=keysteps.meta).eval(), load_part(LlakeyCommandPolicy, folder, "cpu")
    assert apart.forward(batch)[0].item() == pytest.approx(merged.forward(batch)[0].item(), abs=1e-4)


def test_an_adapter_that_does_not_say_its_base_is_named(tmp_path):
    (tmp_path / "adapter_config.json").write_text(json.dumps({"base_model_name_or_path": None}))
    with pytest.raises(ValueError, match="to name what the adapter was trained on, got no name"):
        adapter_base(tmp_path)


def test_a_fresh_small_model_gets_no_adapters(small_config):
    with pytest.raises(ValueError, match="Training from scratch using PEFT"):
        LlakeyCommandPolicy(small_config).wrap_with_peft(peft_cli_overrides={"method_type": "LORA", "r": 4})


def test_an_adapter_that_comes_back_to_itself_is_refused(small_config, tmp_path):
    folders = [tmp_path / name for name in ("one", "other")]
    small_config.use_peft = True
    for folder, base in zip(folders, reversed(folders), strict=True):
        small_config.save_pretrained(folder)
        (folder / "adapter_config.json").write_text(json.dumps({"base_model_name_or_path": str(base)}))
    for bases in ([folders[0]], folders):
        (folders[0] / "adapter_config.json").write_text(json.dumps({"base_model_name_or_path": str(bases[-1])}))
        with pytest.raises(LlakeyError, match="which goes back to itself"):
            LlakeyCommandPolicy.from_pretrained(folders[0])
