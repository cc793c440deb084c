"""A training on pictures looks at a few of them first; one on videos leaves them to ``llakey check``."""

import logging
from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_llakey import schema
from lerobot_llakey.checks import look
from lerobot_llakey.checks.finding import Finding


def test_what_pictures_tell_is_logged(
    sound: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    dataset = LeRobotDataset("local/x", root=sound)
    finding = Finding("depth", "depth in millimetres", "metres", "convert it", certain=False)
    monkeypatch.setattr(look, "check_pictures", lambda sample, _: [finding] if len(sample.hands) else [])
    with caplog.at_level(logging.WARNING):
        look.warn_of_pictures(dataset.meta, schema.CAMERAS, None, "mine")
    assert caplog.messages.count(finding.sentence("mine")) == 1  # other libraries may log, too


def test_metadata_alone_tells_nothing(sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata

    monkeypatch.setattr(look, "draw", lambda *_: pytest.fail("decoded"))
    look.warn_of_pictures(LeRobotDatasetMetadata("local/x", root=sound), schema.CAMERAS, None, "mine")
