"""Runs the stages that are not done, and says how it goes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile

from lerobot_llakey.experiments.rates import Rates
from lerobot_llakey.experiments.stages import Clock, Ledger, Stage
from lerobot_llakey.experiments.trainer import train_all
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.reporting.durations import clock
from lerobot_llakey.reporting.tables import markdown_table


def run_stages(ledger: Ledger, side_by_side: int) -> None:
    """Run all stages that are not done, in order; trainings that follow one another run side by side.

    Args:
        ledger: of the stages, checked.
        side_by_side: trainings at the same time.

    Raises:
        LlakeyError: if a training fails.
    """
    stages = list(ledger.stages.values())
    while left := [stage for stage in stages if not ledger.done(stage.name)]:
        if left[0].training is None:
            _announce(stages, left[0])
            ledger.begin(left[0].name)
            _run_one(ledger, left[0])
        else:
            trainings = list(takewhile(lambda stage: stage.training and _ready(ledger, stage), left))
            for stage in trainings:
                _announce(stages, stage)
                ledger.begin(stage.name)
            _train(ledger, trainings, side_by_side)


def plan_table(ledger: Ledger, rates: Rates, side_by_side: int) -> str:
    """What each stage does, how long it takes here, and whether it is done."""
    rows, total, trainings = [], 0.0, 0.0
    for name, stage in ledger.stages.items():
        seconds, marker = stage.seconds(rates), ledger.markers.get(name)
        state = "done" if ledger.done(name) else "begun" if marker else ""
        if state != "done" and stage.training is None:
            total += seconds
        elif state != "done":
            trainings += seconds
        spent = clock(marker.seconds) if marker and marker.seconds else ""
        rows.append([name, stage.title, clock(seconds), state, spent])
    total += trainings / max(1, side_by_side)
    table = markdown_table(["stage", "what", "about", "state", "took"], rows)
    return f"{table}\n\nAbout {clock(total)} for what is left, from a short measurement on this machine."


def time_table(ledger: Ledger) -> str:
    """What each stage took; the sum of the times is more than the clock says where trainings ran side by side."""
    markers = [(name, ledger.markers[name]) for name in ledger.stages if name in ledger.markers]
    rows = [[name, clock(marker.seconds), clock(marker.cpu_seconds)] for name, marker in markers]
    totals = (sum(marker.seconds for _, marker in markers), sum(marker.cpu_seconds for _, marker in markers))
    return markdown_table(["stage", "time", "processor time"], [*rows, ["added up", *map(clock, totals)]])


def _ready(ledger: Ledger, stage: Stage) -> bool:
    return all(ledger.done(need) for need in stage.needs)


def _announce(stages: Sequence[Stage], stage: Stage) -> None:
    print(f"[{stages.index(stage) + 1}/{len(stages)}] {stage.name}: {stage.title}", flush=True)
    if stage.training is not None:
        print(f"    {stage.training.command_line()}", flush=True)


def _run_one(ledger: Ledger, stage: Stage) -> None:
    spent = Clock()
    try:
        if stage.work is not None:
            stage.work()
    except BaseException:
        ledger.spend(stage.name, *spent.read())
        raise
    ledger.finish(stage.name, *spent.read())


def _train(ledger: Ledger, stages: Sequence[Stage], side_by_side: int) -> None:
    names = {stage.training.name: stage.name for stage in stages if stage.training}

    def finished(training: Training, seconds: float, cpu_seconds: float) -> None:
        ledger.finish(names[training.name], seconds, cpu_seconds)

    train_all([stage.training for stage in stages if stage.training], side_by_side, finished)
