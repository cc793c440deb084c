"""Workers get what they import from one fork server."""

import subprocess
import sys
from pathlib import Path

import pytest

_SCRIPT = """
import gc, multiprocessing, sys

def found_imported():
    return gc.get_freeze_count() > 10_000 and "lerobot_llakey.sim.env" in sys.modules

if __name__ == "__main__":
    from lerobot_llakey.sim.processes import share_imports

    share_imports()
    with multiprocessing.get_context("forkserver").Pool(1) as pool:
        print(pool.apply(found_imported))
"""


@pytest.mark.slow
def test_a_worker_finds_its_imports_done(tmp_path: Path) -> None:
    script = tmp_path / "main.py"
    script.write_text(_SCRIPT)
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "True"
