"""``llakey check`` lists all that is wrong and exits with status 1 where training would be refused."""

from pathlib import Path

import pytest

from fakes import fake_keysteps
from fakes_wrong import WRONG, wrong_dataset
from lerobot_llakey.cli.check import main


def test_sound_and_wrong_datasets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sound = fake_keysteps(tmp_path / "sound", image_size=16).root
    monkeypatch.setattr("sys.argv", ["llakey check", "--repo_id=local/x", f"--root={sound}", "--frames=2"])
    main()
    assert "0 refused" in capsys.readouterr().out
    wrong = tmp_path / "wrong"
    wrong_dataset(sound, wrong, lambda rows: [WRONG[name][1](rows) for name in ("state NaN", "extrinsics identity")])
    monkeypatch.setattr("sys.argv", ["llakey check", "--repo_id=local/x", f"--root={wrong}"])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr().out
    assert ended.value.code == 1
    assert "observation.state" in said
    assert "observation.camera_extrinsics" in said
    assert "refused" in said
