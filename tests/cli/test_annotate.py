"""From a recording of an arm that is not ours to a dataset that passes the check, by commands alone."""

import csv
from pathlib import Path

import pytest

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
