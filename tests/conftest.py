"""What every test needs: a small share of the machine, and no state left over by another test's training run."""

import sys
from collections.abc import Iterator

import pytest
import torch

torch.set_num_threads(2)


@pytest.fixture(autouse=True)
def fresh_accelerator() -> Iterator[None]:
    """Accelerate keeps the settings of a process's first training run; the next one may ask for others."""
    yield
    if "accelerate" in sys.modules:
        from accelerate.state import AcceleratorState

        AcceleratorState._reset_state(reset_partial_state=True)
