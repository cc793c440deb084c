"""Kill collecting at random moments, on this machine and on a Ray cluster, and count what is lost or doubled.

    make torture
    PYTHONPATH=.:tests python -m torture.run --kills=20 --repeats=10 --seed=0

Ends with status 1 where anything was lost, doubled or broken.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from lerobot_llakey.datasets.plan import CollectSettings
from torture.cluster import kill_on_cluster, two_nodes
from torture.kills import kill_collecting
from torture.second import second_collector

TASKS = ("open_drawer", "move_block", "stack_wine")
OPTIONS = (f"--task={','.join(TASKS)}", "--num_episodes=8", "--num_workers=2")


def main() -> int:
    """Run what the command line asks for; the exit status."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--kills", type=int, default=20, help="of llakey collect with SIGKILL")
    options.add_argument("--repeats", type=int, default=10, help="collections on a cluster, one kill in each")
    options.add_argument("--seed", type=int, default=0, help="of the moments")
    given = options.parse_args()
    good, started = True, time.monotonic()
    with tempfile.TemporaryDirectory(prefix="torture-") as folder:
        if given.kills:
            status, sentence, first = second_collector(Path(folder) / "second", OPTIONS)
            print(f"second collector on a folder: status {status}, {sentence!r}; the first: status {first}", flush=True)
            good &= status == 1 and first == 0 and sentence.startswith("error: Expected no other run")
            outcome = kill_collecting(Path(folder) / "kills", given.kills, given.seed, OPTIONS)
            print(f"SIGKILL: {outcome}", flush=True)
            good &= outcome.good
        if given.repeats:
            with two_nodes() as cluster:
                settings = CollectSettings(TASKS, num_episodes=8, split="val", image_size=32)
                outcome = kill_on_cluster(cluster, Path(folder) / "ray", given.repeats, given.seed, settings)
            print(f"Ray, a process or a node killed: {outcome}")
            good &= outcome.good and outcome.kills == given.repeats
    print(f"{(time.monotonic() - started) / 60:.1f} minutes.")
    return int(not good)


if __name__ == "__main__":
    raise SystemExit(main())
