from types import SimpleNamespace

import pytest

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.command.training_dataset import dataset_instructions, dataset_tasks


def test_reads_tasks_and_distinct_instructions(keysteps):
    expected = {keysteps[index][schema.INSTRUCTION] for index in range(len(keysteps))}
    assert dataset_instructions(keysteps.meta) == sorted(expected)
    assert dataset_tasks(keysteps.meta) == sorted({keysteps[index]["task"] for index in range(len(keysteps))})


def test_files_that_are_not_here_give_no_instructions(tmp_path):
    meta = SimpleNamespace(features={schema.INSTRUCTION: {}}, root=tmp_path, repo_id="a/b")
    assert dataset_instructions(meta) == []


def test_dataset_without_instructions_is_named(tmp_path):
    dataset = fake_keysteps(tmp_path / "d", episodes=1, frames=2, cameras=("front",), without=(schema.INSTRUCTION,))
    with pytest.raises(ValueError, match=r"column 'instruction', got 'llakey/fake_keysteps' without it"):
        dataset_instructions(dataset.meta)
