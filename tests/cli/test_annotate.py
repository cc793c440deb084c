"""From a recording of an arm that is not ours to a dataset that passes the check, by commands alone."""

import csv
from pathlib import Path
from typing import Any

import pytest

from fakes_arm import recording, write_urdf
from fakes_recordings import fake_recording, instructions_of, write_calibration
from lerobot_llakey.cli import annotate, check
from lerobot_llakey.datasets.poses import ROTATIONS
from lerobot_llakey.errors import LlakeyError


def run(verb: str, monkeypatch: pytest.MonkeyPatch, *options: str) -> None:
    monkeypatch.setattr("sys.argv", [f"llakey {verb}", *options])
    {"annotate": annotate, "check": check}[verb].main()


@pytest.mark.parametrize(
    ("kind", "options"),
    [("six_joints", []), ("five_joints", ["--gripper=jaw", "--gripper_range=[0,100]"]), ("hand_alone", [])],
)
def test_a_recording_passes_the_check_once_it_is_annotated(
    kind: str,
    options: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    scale = 0.05
    recording, texts, demonstrations = tmp_path / "recording", tmp_path / "texts.csv", tmp_path / "demonstrations"
    fake_recording(recording, kind, scale=scale)
    source = ["--repo_id=me/recording", f"--root={recording}", *options]
    run("annotate", monkeypatch, *source, f"--template={texts}")
    with texts.open(newline="") as file:
        rows = list(csv.DictReader(file))
    given = instructions_of()
    with texts.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        for row in rows:
            writer.writerow(row | {"instruction": given[int(row["episode"])][int(row["segment"])]})
    if kind != "five_joints":
        source.append(f"--calibration={write_calibration(tmp_path / 'calibration.yaml', kind, scale)}")
    target = ["--output_repo_id=me/demonstrations", f"--output_root={demonstrations}"]
    run("annotate", monkeypatch, *source, f"--instructions={texts}", *target)
    capsys.readouterr()
    run("check", monkeypatch, "--repo_id=me/demonstrations", f"--root={demonstrations}")
    assert "2 episodes" in (said := capsys.readouterr().out)
    assert "0 refused, 0 warnings" in said, said


@pytest.mark.parametrize("rotation", ROTATIONS)
def test_the_help_names_every_rotation(rotation: str) -> None:
    assert rotation in (annotate.AnnotateConfig.__doc__ or "")


def test_a_calibration_of_other_cameras_is_refused_before_anything_is_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_recording(tmp_path / "recording", "hand_alone", episodes=1, scale=0.05)
    config = annotate.AnnotateConfig(
        "me/recording",
        tmp_path / "recording",
        output_repo_id="me/x",
        output_root=tmp_path / "x",
        calibration=write_calibration(tmp_path / "calibration.yaml", "six_joints"),
    )
    monkeypatch.setattr("builtins.input", lambda _: pytest.fail("asked"))
    with pytest.raises(LlakeyError, match=r"cameras phone in .*got front"):
        annotate.run(config)


JOINTS = ["--urdf={arm}", "--tip=tip", "--joint_unit=degrees", "--gripper_range=[0,100]"]
SKILLS = """
take:
  descriptions: ["take the {thing}"]
  sequences: [["move to the top of the {thing}", "grasp the {thing}", "raise the robotic arm"]]
"""


def test_joints_alone_and_a_file_of_skills_make_demonstrations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    recording(tmp_path / "recording")
    (tmp_path / "skills.yaml").write_text(SKILLS)
    source = ["--repo_id=me/joints", f"--root={tmp_path / 'recording'}", f"--instructions={tmp_path / 'skills.yaml'}"]
    source += [option.format(arm=write_urdf(tmp_path / "arm.urdf")) for option in JOINTS]
    run("annotate", monkeypatch, *source, f"--template={tmp_path / 'texts.csv'}")
    with (tmp_path / "texts.csv").open(newline="") as file:
        assert [row["instruction"] for row in csv.DictReader(file)][1] == "grasp the cup"
    run("annotate", monkeypatch, *source, "--output_repo_id=me/out", f"--output_root={tmp_path / 'out'}")
    capsys.readouterr()
    run("check", monkeypatch, "--repo_id=me/out", f"--root={tmp_path / 'out'}")
    assert "0 refused" in (said := capsys.readouterr().out), said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"tip": "tip"}, r"--urdf and --tip together, got --tip=tip alone"),
        ({"joint_unit": "degrees"}, r"--urdf and --tip together, got --joint_unit=degrees alone"),
        ({"depth": Path("nowhere")}, r"folder of depth pictures at nowhere, found none"),
        ({"instructions": "nowhere.yaml"}, r"YAML file of instructions at nowhere.yaml, found none"),
        ({"instructions": "subtask"}, r"column language_persistent with rows of style subtask"),
    ],
)
def test_what_is_missing_is_said_in_one_sentence(options: dict[str, Any], said: str, tmp_path: Path) -> None:
    fake_recording(tmp_path / "recording", "hand_alone", episodes=1, scale=0.05)
    target = {"output_repo_id": "me/x", "output_root": tmp_path / "x"}
    with pytest.raises(LlakeyError, match=said):
        annotate.run(annotate.AnnotateConfig("me/recording", tmp_path / "recording", **target, **options))
