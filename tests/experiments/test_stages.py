"""Markers: what is done stays done, what has changed is noticed, what follows from it is done anew."""

from pathlib import Path

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments.stages import MARKERS, Ledger, Stage


def chain(folder: Path, steps: int = 3) -> list[Stage]:
    """Three stages, each of which needs the one before."""
    settings = ({"episodes": 5}, {"policy": {"steps": steps}}, {})
    return [
        Stage(name, name, setting, (before,) if before else (), (folder / name,))
        for name, setting, before in zip(("a", "b", "c"), settings, ("", "a", "b"), strict=True)
    ]


def finish_all(ledger: Ledger, folder: Path) -> None:
    for name in ledger.stages:
        if not ledger.done(name):
            ledger.begin(name)
            (folder / name).write_text("result")
            ledger.finish(name, 1.0, 2.0)


def test_what_is_done_is_done_for_the_next_run(tmp_path: Path) -> None:
    finish_all(Ledger(tmp_path, chain(tmp_path)), tmp_path)
    again = Ledger(tmp_path, chain(tmp_path))
    again.check()
    assert all(again.done(name) for name in again.stages)


def test_a_stage_that_was_only_begun_goes_on_and_adds_its_time(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path, chain(tmp_path))
    ledger.begin("a")
    (tmp_path / "a").write_text("half")
    ledger.spend("a", 2.0, 3.0)
    again = Ledger(tmp_path, chain(tmp_path))
    assert not again.done("a")
    again.begin("a")
    assert (tmp_path / "a").read_text() == "half"
    again.finish("a", 1.0, 1.0)
    assert (again.markers["a"].seconds, again.markers["a"].cpu_seconds) == (3.0, 4.0)


def test_a_changed_setting_is_named(tmp_path: Path) -> None:
    finish_all(Ledger(tmp_path, chain(tmp_path)), tmp_path)
    changed = Ledger(tmp_path, chain(tmp_path, steps=4))
    with pytest.raises(
        ValueError, match=r"stage b was begun, got a change of policy\.steps \(from 3 to 4\); .*--redo=b"
    ):
        changed.check()


def test_doing_a_stage_anew_takes_along_what_follows_and_nothing_else(tmp_path: Path) -> None:
    finish_all(Ledger(tmp_path, chain(tmp_path)), tmp_path)
    ledger = Ledger(tmp_path, chain(tmp_path, steps=4))
    assert ledger.forget(["b"]) == ["b", "c"]
    ledger.check()
    assert ledger.done("a") and not ledger.done("b") and not ledger.done("c")
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == ["a"]


def test_what_was_made_of_an_earlier_result_does_not_count(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path, chain(tmp_path))
    finish_all(ledger, tmp_path)
    (tmp_path / "stages" / "a.json").unlink()  # as a person would
    ledger = Ledger(tmp_path, chain(tmp_path))
    assert not ledger.done("c")
    ledger.begin("a")
    ledger.finish("a", 1.0, 1.0)
    assert not ledger.done("b")
    ledger.begin("b")
    assert not (tmp_path / "b").exists()


def test_an_unknown_stage_cannot_be_done_anew(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="Expected stages out of a, b, c, got 'd'"):
        Ledger(tmp_path, chain(tmp_path)).forget(["d"])


@pytest.mark.parametrize("content", ['{"settings": ', "[1]", '{"colour": "red"}'])
def test_a_broken_marker_is_named(tmp_path: Path, content: str) -> None:
    stages = chain(tmp_path)
    marker = tmp_path / MARKERS / f"{stages[0].name}.json"
    marker.parent.mkdir(parents=True)
    marker.write_text(content)
    with pytest.raises(LlakeyError, match=rf"Expected a readable record of a stage at {marker}"):
        Ledger(tmp_path, stages)
