"""LeRobot's own policies train on our keysteps as they come and act in the simulator, by stock flags alone."""

import json
import sys
from pathlib import Path

import pytest
from lerobot.scripts import lerobot_eval, lerobot_train

from lerobot_llakey import schema
from lerobot_llakey.datasets.plan import Targets

INPUTS = {
    schema.STATE: {"type": "STATE", "shape": [len(schema.SIM_STATE_NAMES)]},
    schema.image_key("front"): {"type": "VISUAL", "shape": [3, 32, 32]},
}
TINY = {
    "act": ("dim_model=16", "n_heads=2", "dim_feedforward=16", "n_encoder_layers=1", "n_vae_encoder_layers=1"),
    "vqbet": (
        *("use_group_norm=true", "crop_shape=null", "n_vqvae_training_steps=1", "gpt_n_layer=1", "gpt_n_head=2"),
        *("gpt_input_dim=16", "gpt_output_dim=16", "gpt_hidden_dim=16", "vqvae_enc_hidden_dim=16"),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("policy", sorted(TINY))
def test_trains_on_keysteps_and_acts(
    policy: str, collected: Targets, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(main, *options: str) -> None:
        monkeypatch.setattr(sys, "argv", ["lerobot", *options])
        main()

    run(
        lerobot_train.main,
        f"--policy.type={policy}",
        *(f"--policy.{setting}" for setting in TINY[policy]),
        "--policy.pretrained_backbone_weights=null",
        f"--policy.input_features={json.dumps(INPUTS)}",
        "--dataset.repo_id=local/keysteps",
        f"--dataset.root={collected.keysteps}",
        f"--output_dir={tmp_path / 'trained'}",
        *("--policy.device=cpu", "--policy.push_to_hub=false", "--batch_size=2", "--steps=2", "--num_workers=0"),
    )
    run(
        lerobot_eval.main,
        f"--policy.path={tmp_path / 'trained/checkpoints/last/pretrained_model'}",
        "--policy.device=cpu",
        *("--env.type=llakey_sim", "--env.task=open_drawer", "--env.image_size=32", "--env.episode_length=1"),
        *("--eval.n_episodes=1", "--eval.batch_size=1"),
        f"--output_dir={tmp_path / 'evaluated'}",
    )
    assert json.loads((tmp_path / "evaluated/eval_info.json").read_text())["overall"]["n_episodes"] == 1
