import json
from pathlib import Path

import pytest

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.datasets.collect_record import RECORD
from lerobot_llakey.datasets.rewrite import drop
from lerobot_llakey.evaluation.abilities.samples import check_columns, samples, task_names


def test_an_episodes_last_frame_is_left_out_where_all_frames_are_there(dataset):
    chosen = samples(dataset)
    assert {index % 6 for index in chosen} == {0, 1, 2, 3, 4}
    assert chosen == sorted(set(chosen))


def test_keysteps_are_all_taken(tmp_path: Path):
    keysteps = fake_keysteps(
        tmp_path / "d", episodes=2, frames=4, image_size=16, cameras=("front",), without=(schema.NEXT_KEYFRAME,)
    )
    assert samples(keysteps) == list(range(8))
    assert samples(keysteps, max_samples=3) == [0, 3, 7]
    with pytest.raises(ValueError, match="max_samples of 1 or more"):
        samples(keysteps, max_samples=0)


def test_tasks_are_named_by_the_column_the_record_or_the_skill_instruction(tmp_path: Path):
    keysteps = fake_keysteps(tmp_path / "d", episodes=3, frames=2, image_size=16, cameras=("front",))
    assert set(task_names(keysteps)) == {"pick_up"}
    drop(keysteps.root, schema.ORIGIN_COLUMNS)
    old = type(keysteps)(keysteps.repo_id, root=keysteps.root)
    skills = [old[index][schema.TASK] for index in range(6)]
    assert task_names(old) == skills and len(set(skills)) > 1
    record = {"settings": {"tasks": ["open_drawer", "close_jar"]}, "episodes": 3, "discarded": {}}
    (keysteps.root / RECORD).write_text(json.dumps(record))
    assert task_names(old) == ["open_drawer"] * 2 + ["close_jar"] * 2 + ["open_drawer"] * 2
    (keysteps.root / RECORD).write_text(json.dumps(record | {"episodes": 2}))
    assert task_names(old) == skills


@pytest.mark.parametrize("key", [schema.IS_KEYFRAME, schema.INSTRUCTION])
def test_a_dataset_without_what_is_needed_is_refused(tmp_path: Path, key: str):
    lacking = fake_keysteps(tmp_path / "d", episodes=1, frames=2, image_size=16, cameras=("front",), without=(key,))
    with pytest.raises(ValueError, match=rf"columns \['{key}'\]"):
        check_columns(lacking)
