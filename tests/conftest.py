"""What every test needs: a small share of the machine, and no state left over by another test's training run."""

import sys
from collections.abc import Iterator

import pytest
import torch

# Tensors are small here: a second thread waits more than it computes, most of all on a busy machine.
torch.set_num_threads(1)


@pytest.fixture(autouse=True)
def fresh_accelerator() -> Iterator[None]:
    """Accelerate keeps the settings of a process's first training run; the next one may ask for others."""
    yield
    if "accelerate" in sys.modules:
        from accelerate.state import AcceleratorState

        AcceleratorState._reset_state(reset_partial_state=True)
