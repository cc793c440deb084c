import json
from pathlib import Path

from lerobot_llakey.evaluation.abilities.files import write_abilities
from lerobot_llakey.evaluation.abilities.measure import ABILITIES, Measured


def test_every_file_is_there_and_named(tmp_path: Path) -> None:
    measured = Measured()
    measured.add(ABILITIES[0], "move_cup", "", "grasp the cup", "release the cup")
    folder = tmp_path / "new" / "abilities"
    written = write_abilities(measured, folder)
    assert set(written) == set(folder.iterdir()) and len(written) == 6
    assert json.loads(written[0].read_text()) == json.loads(json.dumps(measured.summary()))
