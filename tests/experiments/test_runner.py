"""Stages run in order, once; a run that is ended goes on with the stage that it was in."""

from pathlib import Path

import pytest

from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.runner import plan_table, run_stages, time_table
from lerobot_llakey.experiments.stages import Ledger, Stage


class Work:
    """Three stages that write down when they run, the second of which may be cut short."""

    def __init__(self, folder: Path) -> None:
        self.calls: list[str] = []
        self.cut_short = True
        self.folder = folder

    def stages(self) -> list[Stage]:
        names = ("first", "second", "third")
        return [
            Stage(name, f"the {name}", {}, names[:index], (), lambda name=name: self.do(name), seconds=lambda _: 60.0)
            for index, name in enumerate(names)
        ]

    def do(self, name: str) -> None:
        if name == "second" and self.cut_short:
            raise KeyboardInterrupt
        self.calls.append(name)


def test_an_ended_run_goes_on_where_it_was(tmp_path: Path) -> None:
    work = Work(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        run_stages(Ledger(tmp_path, work.stages()), 1)
    work.cut_short = False
    ledger = Ledger(tmp_path, work.stages())
    run_stages(ledger, 1)
    assert work.calls == ["first", "second", "third"]
    run_stages(Ledger(tmp_path, work.stages()), 1)
    assert len(work.calls) == 3


def test_the_plan_says_what_is_left(tmp_path: Path) -> None:
    work = Work(tmp_path)
    assert "About 3 min for what is left" in plan_table(Ledger(tmp_path, work.stages()), Rates(), 1)
    with pytest.raises(KeyboardInterrupt):
        run_stages(Ledger(tmp_path, work.stages()), 1)
    table = plan_table(Ledger(tmp_path, work.stages()), Rates(), 1)
    states = [line.split("|")[4].strip() for line in table.splitlines()[2:5]]
    assert states == ["done", "begun", ""] and "About 2 min for what is left" in table
    assert "| added up" in time_table(Ledger(tmp_path, work.stages()))
