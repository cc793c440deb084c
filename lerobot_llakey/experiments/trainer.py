"""Runs trainings in processes of their own, some side by side, each with a progress bar and a log."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from multiprocessing import get_context
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import torch
from tqdm import tqdm

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.experiments.stages import Clock
from lerobot_llakey.experiments.training import Training
from lerobot_llakey.parallel import end_with_parent

_LEROBOT_TRAIN = "lerobot.scripts.lerobot_train"
_POLL_SECONDS = 1.0


def train_all(
    trainings: Sequence[Training], side_by_side: int, finished: Callable[[Training, float, float], None]
) -> None:
    """Train until all are done, each from its last checkpoint where there is one.

    Args:
        trainings: in the order in which they start.
        side_by_side: how many at the same time; each gets its share of the CPU cores.
        finished: told of each that is done, with the wall-clock and the processor seconds that it took.

    Raises:
        LlakeyError: if one fails; its log says why. The others are ended and go on when started again.
    """
    # A process forked from one that has imported all that training needs starts at once.
    context = get_context("forkserver")
    context.set_forkserver_preload([__name__, _LEROBOT_TRAIN])
    threads = max(1, torch.get_num_threads() // max(1, side_by_side))
    waiting, running = list(trainings), dict[int, _Run]()
    try:
        while waiting or running:
            while waiting and len(running) < max(1, side_by_side):
                run = _Run(waiting.pop(0), context, threads, position=len(running))
                running[run.process.sentinel] = run
            wait(list(running), timeout=_POLL_SECONDS)
            for sentinel, run in list(running.items()):
                if run.over():
                    del running[sentinel]
                    run.check()
                    finished(run.training, *run.usage())
    finally:
        for run in running.values():
            run.end()


class _Run:
    """One training under way."""

    def __init__(self, training: Training, context: Any, threads: int, position: int) -> None:
        self.training, self._clock = training, Clock()
        saved, steps = training.steps_saved(), training.steps
        if not saved and training.output_dir.exists():
            shutil.rmtree(training.output_dir)  # ended before its first checkpoint; LeRobot refuses the folder
        training.log.parent.mkdir(parents=True, exist_ok=True)
        training.log.unlink(missing_ok=True)
        self._steps, self._usage = steps, training.log.with_suffix(".usage")
        words = [] if saved >= steps else training.arguments()
        arguments = (words, str(training.log), str(self._usage), training.launcher, threads)
        self._bar = tqdm(total=steps, initial=saved, desc=training.name, unit="step", position=position)
        self.process: BaseProcess = context.Process(target=run_training, args=arguments)
        self.process.start()

    def over(self) -> bool:
        """Whether it has ended; moves the bar."""
        alive = self.process.is_alive()
        done = max(self._bar.n, self.training.steps_logged(self._steps))
        self._bar.update(done - self._bar.n)
        if not alive:
            self.process.join()
            self._bar.close()
        return not alive

    def check(self) -> None:
        if self.process.exitcode or self.training.steps_saved() < self._steps:
            raise LlakeyError(
                f"Expected the training {self.training.name} to reach step {self._steps}, got exit status "
                f"{self.process.exitcode} ({self.training.last_words()[-300:]}); see {self.training.log}."
            )

    def usage(self) -> tuple[float, float]:
        cpu_seconds = json.loads(self._usage.read_text())["cpu_seconds"] if self._usage.exists() else 0.0
        return self._clock.read()[0], cpu_seconds

    def end(self) -> None:
        self.process.terminate()
        self.process.join()
        self._bar.close()


def run_training(arguments: list[str], log: str, usage: str, launcher: str, threads: int) -> None:
    """What a training's process does; it does not outlive the process that started it.

    Args:
        arguments: of ``lerobot-train``; nothing is done without any.
        log: file for all that is printed.
        usage: file for the processor seconds that it took.
        launcher: words in place of python, such as ``accelerate launch``; training is here where empty.
        threads: of PyTorch.
    """
    if not arguments:
        return
    clock = Clock()
    with open(log, "w") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    sys.stdout, sys.stderr = os.fdopen(1, "w", buffering=1), os.fdopen(2, "w", buffering=1)
    os.setpgid(0, 0)  # a group of its own, ended as a whole with the processes that load its samples
    signal.signal(signal.SIGTERM, lambda *_: _end_group())
    end_with_parent(_end_group)
    if launcher:
        subprocess.run([*shlex.split(launcher), "-m", _LEROBOT_TRAIN, *arguments], check=True)
    else:
        import lerobot.scripts.lerobot_train as lerobot_train

        torch.set_num_threads(threads)
        sys.argv = ["lerobot-train", *arguments]
        lerobot_train.main()
    Path(usage).write_text(json.dumps({"cpu_seconds": clock.read()[1]}))


def _end_group() -> None:
    os.killpg(0, signal.SIGKILL)
