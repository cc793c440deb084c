"""Hand in generated wrong inputs of all kinds; each must be answered with one sentence or put right.

    make fuzz
    PYTHONPATH=.:tests python -m fuzz.run --count=500 --seed=0
    PYTHONPATH=.:tests python -m fuzz.run --kinds=dataset,batch --show   # every sentence
    PYTHONPATH=.:tests python -m fuzz.run --kinds=corrupted --count=200  # files that went bad

Ends with status 1 where an input passed in silence, was answered with a traceback or without naming it, or ended the
process by a signal or a hang.
"""

from __future__ import annotations

import argparse
import importlib
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import torch
from tqdm import tqdm

from fuzz import actions, batches, checkpoints, command_lines, corrupted, datasets_on_disk, servers, settings, texts
from fuzz.case import BAD, GOOD, Case, Outcome
from fuzz.runner import run_cases
from lerobot_llakey.cli.main import VERBS

KINDS: dict[str, Callable[[Path, np.random.Generator], Iterator[Case]]] = {
    "dataset": datasets_on_disk.cases,
    "corrupted": corrupted.cases,
    "batch": batches.cases,
    "checkpoint": checkpoints.cases,
    "settings": settings.cases,
    "command line": command_lines.cases,
    "server": servers.cases,
    "action": actions.cases,
    "text": texts.cases,
}
"""Generators of cases: given a folder for what they share and a source of chance, all that they can think of."""


FOREIGN = "corrupted, no checksums"
"""Files that went bad in datasets of others, which no checksum tells: counted when asked for, not asked of us."""


def draw(kinds: list[str], count: int, seed: int, folder: Path) -> list[Case]:
    """So many cases, spread evenly over the kinds as far as these have as many.

    Args:
        kinds: names of KINDS.
        count: of cases in all.
        seed: of the draw.
        folder: where what the cases share is made.
    """
    rng = np.random.default_rng(seed)
    known = KINDS | {FOREIGN: partial(corrupted.cases, noted=False)}
    found = {kind: list(known[kind](folder / kind.replace(" ", "_"), rng)) for kind in kinds}
    chosen: list[Case] = []
    for position, kind in enumerate(sorted(kinds, key=lambda kind: len(found[kind]))):
        share = min(len(found[kind]), (count - len(chosen)) // (len(kinds) - position))
        chosen += [found[kind][index] for index in sorted(rng.permutation(len(found[kind]))[:share])]
    return chosen


def _import_once() -> None:
    """Import what the cases import, so that they need not do it one by one."""
    for module, _ in VERBS.values():
        importlib.import_module(module)
    for name in ("lerobot.datasets.lerobot_dataset", "lerobot.policies.factory", "lerobot_llakey.sim.env", "openai"):
        importlib.import_module(name)


def table(outcomes: list[Outcome]) -> str:
    """The counts of each result, by kind, in Markdown."""
    results = (*GOOD, *BAD)
    rows = [f"| kind | {' | '.join(results)} |", f"|---{'|---' * len(results)}|"]
    for kind in dict.fromkeys(outcome.case.kind for outcome in outcomes):
        counts = Counter(outcome.result for outcome in outcomes if outcome.case.kind == kind)
        rows.append(f"| {kind} | {' | '.join(str(counts[result]) for result in results)} |")
    total = Counter(outcome.result for outcome in outcomes)
    return "\n".join([*rows, f"| all {len(outcomes)} | {' | '.join(str(total[result]) for result in results)} |"])


def main() -> int:
    """Run what the command line asks for; the exit status."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--count", type=int, default=500, help="wrong inputs in all")
    options.add_argument("--seed", type=int, default=0, help="of the draw")
    options.add_argument("--kinds", default=",".join(KINDS), help=f"which, separated by commas; or '{FOREIGN}'")
    options.add_argument("--only", default="", help="cases whose name holds this text")
    options.add_argument("--workers", type=int, default=os.cpu_count(), help="processes at once")
    options.add_argument("--show", action="store_true", help="print every answer, not the bad ones alone")
    given = options.parse_args()
    _import_once()
    torch.set_num_threads(1)  # a thread of the parent is not there in a forked child
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="fuzz-shared-") as folder:
        cases = draw(
            [given.kinds] if given.kinds == FOREIGN else given.kinds.split(","), given.count, given.seed, Path(folder)
        )
        cases = [case for case in cases if given.only in case.name]
        outcomes = []
        for outcome in tqdm(run_cases(cases, given.workers), total=len(cases), unit="input"):
            outcomes.append(outcome)
            if given.show or outcome.result in BAD:
                text = " ".join(outcome.text.split())[:400]
                seconds = f"{outcome.seconds:.1f} s"
                tqdm.write(f"{outcome.result:9} {outcome.case.kind}: {outcome.case.name} ({seconds}): {text}")
    print(table(outcomes))
    print(f"{len(outcomes)} inputs in {(time.monotonic() - started) / 60:.1f} minutes.")
    return int(any(outcome.result in BAD for outcome in outcomes))


if __name__ == "__main__":
    raise SystemExit(main())
