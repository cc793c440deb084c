"""What every test needs: a small share of the machine, and no state left over by another test's training run."""

import os
import sys
from collections.abc import Iterator

import pytest

# Tensors are small here: a second thread waits more than it computes, most of all on a busy machine. The variables are
# for the processes that tests start.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("TOKENIZERS_PARALLELISM", "false")
import torch

torch.set_num_threads(1)


@pytest.fixture(autouse=True)
def fresh_accelerator() -> Iterator[None]:
    """Accelerate keeps the settings of a process's first training run; the next one may ask for others."""
    yield
    if "accelerate" in sys.modules:
        from accelerate.state import AcceleratorState

        AcceleratorState._reset_state(reset_partial_state=True)
