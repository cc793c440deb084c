"""A foreign recording goes through every verb of docs/own_arm.md, and through lerobot-train, with stock flags."""

import csv
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from lerobot.configs import PreTrainedConfig
from lerobot.scripts import lerobot_train

from fakes_recordings import fake_recording, write_calibration
from lerobot_llakey.cli.main import main

TINY_ACTION = {
    **{"widths": "[16,24,32]", "blocks": "[1,1]", "transformer_layers": 1, "transformer_heads": 2, "view_size": 64},
    **{"text_width": 32, "text_layers": 1},
}
TINY_COMMAND = {
    **{"vision_width": 32, "vision_layers": 1, "vision_heads": 2, "text_width": 32, "text_layers": 1, "text_heads": 2},
    **{"image_size": 64},
}
GRAMMAR = """
templates:
  press:
    wordings: ["press {thing}", "push {thing} down"]
    gripper: closed
  pour:
    wordings: ["pour {held} into {target}"]
  up:
    wordings: ["come up"]
"""
WORDS = {
    "basic": ["move to the top of the red block", "grasp the red block", "raise the robotic arm"],
    "own": ["come up", "press the red block", "pour the red block into the blue bowl"],
    "free": ["Get over the red thing!", "now close your fingers on it", "and up you go"],
}
ARMS = {
    "six_joints": ["--calibration={calibration}"],
    "five_joints": ["--gripper=jaw", "--gripper_range=[0,100]"],
}
Run = Callable[..., str]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    def call(verb: str, *options: str) -> str:
        monkeypatch.setattr(sys, "argv", [verb, *options])
        if verb == "lerobot-train":
            lerobot_train.main()
        else:
            main([verb, *options])
        return capsys.readouterr().out

    return call


def fill_in(path: Path, words: list[str]) -> None:
    """What a person does with the template."""
    rows = list(csv.DictReader(path.open()))
    for row in rows:
        row["instruction"] = words[int(row["segment"])]
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def flags(prefix: str, settings: dict) -> list[str]:
    return [f"--{prefix}.{name}={value}" for name, value in settings.items()]


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "words"), [("five_joints", "basic"), ("six_joints", "own"), ("six_joints", "free")])
def test_from_a_recording_to_a_policy_and_its_figures(arm: str, words: str, run: Run, tmp_path: Path) -> None:
    recording = fake_recording(tmp_path / "recording", arm, scale=0.25)
    (tmp_path / "own.yaml").write_text(GRAMMAR)
    calibration = write_calibration(tmp_path / "calibration.yaml", arm, scale=0.25)
    source = [f"--repo_id={recording.repo_id}", f"--root={recording.root}"]
    source += [option.format(calibration=calibration) for option in ARMS[arm]]
    source += [f"--grammar={tmp_path / 'own.yaml' if words == 'own' else words}"]
    table, demonstrations, keysteps = tmp_path / "words.csv", tmp_path / "demonstrations", tmp_path / "keysteps"
    run("annotate", *source, f"--template={table}")
    fill_in(table, WORDS[words])
    made = ["--output_repo_id=me/demonstrations", f"--output_root={demonstrations}"]
    run("annotate", *source, f"--instructions={table}", *made)
    data = ["--repo_id=me/demonstrations", f"--root={demonstrations}"]
    assert "0 refused, 0 warnings" in run("check", *data)
    run("keysteps", *data, "--output_repo_id=me/keysteps", f"--output_root={keysteps}")
    data = ["--repo_id=me/keysteps", f"--root={keysteps}"]
    assert "0 refused, 0 warnings" in run("check", *data)
    tiny = {
        "llakey_action": flags("policy", TINY_ACTION),
        "llakey_command": flags("policy", TINY_COMMAND),
        "llakey": [*flags("policy.action", TINY_ACTION), *flags("policy.command", TINY_COMMAND)],
    }
    for kind, settings in tiny.items():
        run(
            *("lerobot-train", f"--policy.type={kind}", "--policy.device=cpu", "--policy.push_to_hub=false"),
            *("--dataset.repo_id=me/keysteps", f"--dataset.root={keysteps}", f"--output_dir={tmp_path / kind}"),
            *("--batch_size=2", "--steps=2", "--num_workers=0", *settings),
        )
        checkpoint = tmp_path / kind / "checkpoints/last/pretrained_model"
        config = PreTrainedConfig.from_pretrained(checkpoint)
        assert config.grammar == (words if words != "own" else config.rules.to_data())
        policy = [f"--policy_path={checkpoint}", *data]
        if kind != "llakey_action":
            assert "| all" in run("abilities", *policy, f"--output_dir={tmp_path / f'abilities_{kind}'}")
        if kind != "llakey_command":
            assert "| all" in run("keyframe-accuracy", *policy)
            assert WORDS[words][0] in run("show", *policy, f"--output={tmp_path / f'{kind}.png'}")
