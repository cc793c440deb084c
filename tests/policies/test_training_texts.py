"""What LeRobot's processors drop is found again by the frames' index."""

from pathlib import Path

import pytest
import torch

from fakes import fake_keysteps
from lerobot_llakey import schema
from lerobot_llakey.policies.training_texts import TrainingTexts, training_texts


def test_frames_get_their_own_texts_and_given_ones_win(tmp_path: Path) -> None:
    dataset = fake_keysteps(tmp_path / "keysteps", episodes=3)
    texts = training_texts(dataset.meta)
    assert training_texts(dataset.meta) is texts
    index = torch.tensor([16, 2, 9, 2])
    filled = texts.fill({schema.INDEX: index[:, None]})
    for key in schema.TEXTS:
        assert filled[key] == [dataset[int(place)][key] for place in index]
    assert texts.fill({schema.INDEX: index, schema.INSTRUCTION: ["mine"] * 4})[schema.INSTRUCTION] == ["mine"] * 4
    assert schema.INSTRUCTION not in texts.fill({}) and schema.INSTRUCTION not in TrainingTexts(None).fill(
        {schema.INDEX: index}
    )


def test_a_frame_of_another_dataset_is_named(tmp_path: Path) -> None:
    texts = training_texts(fake_keysteps(tmp_path / "keysteps").meta)
    for wrong in (12, -1):
        with pytest.raises(ValueError, match=f"index of the training dataset's 12 frames, got {wrong}"):
            texts.fill({schema.INDEX: torch.tensor([0, wrong])})
