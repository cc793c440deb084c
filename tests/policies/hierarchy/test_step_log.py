import json
from pathlib import Path

from fakes_steps import a_step
from lerobot_llakey.policies.hierarchy.step_log import EpisodeLog


def test_keeps_the_steps_of_each_row_and_forgets_them_with_the_episode() -> None:
    log = EpisodeLog()
    log.begin([1, 2], seed=0)
    log.add([a_step(0), a_step(1)])
    log.add([a_step(0, index=1), a_step(1, index=1)])
    assert [[step.index for step in row] for row in log.steps] == [[0, 1], [0, 1]]
    log.begin([3], seed=0)
    assert log.steps == [[]]


def test_writes_one_file_an_episode_and_the_same_episode_anew(tmp_path: Path) -> None:
    log = EpisodeLog(tmp_path / "log")
    for _ in range(2):
        log.begin([1, 2, 1], seed=5)
        log.add([a_step(row, said=f"row {row}") for row in range(3)])
        log.add([a_step(row, index=1) for row in range(3)])
    files = sorted((tmp_path / "log").iterdir())
    names = ["0000000000000001_seed5.jsonl", "0000000000000001_seed5_1.jsonl", "0000000000000002_seed5.jsonl"]
    assert [file.name for file in files] == names
    lines = [[json.loads(line) for line in file.read_text().splitlines()] for file in files]
    assert [[line["index"] for line in file] for file in lines] == [[0, 1]] * 3
    assert [file[0]["said"] for file in lines] == ["row 0", "row 2", "row 1"]
    assert lines[0][0] == json.loads(json.dumps(a_step(0, said="row 0").as_json()))


def test_a_step_can_be_written_down() -> None:
    read = json.loads(json.dumps(a_step(3, likelihood=None, moved=True, sent=(1 / 3, *[0.0] * 8)).as_json()))
    assert (read["row"], read["likelihood"], read["moved"], len(read["state"])) == (3, None, True, 8)
    assert read["sent"] == [0.333333, *[0.0] * 8]
