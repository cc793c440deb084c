"""Pickles from strangers, read without running any of their code.

A pickle names functions and calls them; whoever loads one with Python's own loader runs what its author wished. Here
every name is looked up in a closed list, :data:`NUMPY_NAMES` and plain containers in place of RLBench's two classes,
and a name outside it ends the reading.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy._core import multiarray

from lerobot_llakey.errors import LlakeyError, said
from lerobot_llakey.files import reading

_CONTAINERS = {("rlbench.demo", "Demo"), ("rlbench.backend.observation", "Observation")}
"""RLBench's classes, of which a plain container takes the place."""
_MOST_BYTES = 1 << 30
"""Of a file: RLBench's hold the numbers of one episode, a few megabytes."""


def _latin(text: str, encoding: str) -> bytes:
    """What protocols up to 2 call for bytes, ``codecs.encode``, for its one use."""
    if encoding != "latin1":
        raise pickle.UnpicklingError(f"bytes as {encoding}")
    return text.encode("latin1")


def _from_buffer(buffer: bytes, dtype: np.dtype, shape: tuple[int, ...], order: Any, *_: object) -> np.ndarray:
    """What protocol 5 calls for arrays."""
    return np.frombuffer(buffer, dtype).reshape(shape, order=order)


_RECONSTRUCT: Mapping[str, Any] = {"_reconstruct": multiarray._reconstruct, "scalar": multiarray.scalar}
NUMPY_NAMES: Mapping[tuple[str, str], Callable[..., Any]] = {
    ("numpy", "ndarray"): np.ndarray,
    ("numpy", "dtype"): np.dtype,
    # Numpy 1 and numpy 2 write their arrays under different names of one module.
    **{(f"numpy.{core}.multiarray", name): one for core in ("core", "_core") for name, one in _RECONSTRUCT.items()},
    **{(f"numpy.{core}.numeric", "_frombuffer"): _from_buffer for core in ("core", "_core")},
    ("_codecs", "encode"): _latin,
}
"""The functions that a pickle may call: those that make arrays and numbers of bytes."""


def read_pickle(path: Path) -> Any:
    """What a pickle holds: numbers, texts, lists, dictionaries, arrays, and RLBench's objects as plain containers.

    Args:
        path: of the file, which may come from anyone.

    Returns:
        The content. An object of RLBench's has the attributes of the original, and a class of the same name.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it names a class or function outside the closed list, or cannot be read to its end.
    """
    with reading(path, "pickle"):
        if path.stat().st_size > _MOST_BYTES:
            raise LlakeyError(
                f"Expected at most {_MOST_BYTES >> 20} MiB in {path}, got {path.stat().st_size >> 20}; check the file."
            )
        content = path.read_bytes()
    reader = _Reader(content)
    try:
        return reader.load()
    except Exception as error:  # whatever foreign bytes lead to is a fault of the file
        if reader.refused:
            raise LlakeyError(
                f"Expected only numbers and RLBench's own classes in {path}, got {reader.refused}; it is not read, as "
                "it could run code: ask where the file comes from."
            ) from error
        told = said(error, 120) or "its end is missing"
        raise LlakeyError(
            f"Expected a whole pickle at {path}, got one that is broken ({type(error).__name__}: {told}); fetch it "
            "anew."
        ) from error


class _Reader(pickle.Unpickler):
    """Looks names up in the closed list alone.

    Attributes:
        refused: the first name outside the list, "" without one.
    """

    def __init__(self, content: bytes) -> None:
        super().__init__(io.BytesIO(content))
        self.refused = ""
        # New classes for each file: nothing that a pickle sets on one reaches another file, or the program.
        self._containers = {(module, name): type(name, (), {}) for module, name in _CONTAINERS}

    def find_class(self, module: str, name: str) -> Any:
        found = self._containers.get((module, name)) or NUMPY_NAMES.get((module, name))
        if found is None:
            self.refused = self.refused or f"{module}.{name}"
            raise pickle.UnpicklingError("a name outside the closed list")
        return found

    def persistent_load(self, pid: Any) -> Any:
        self.refused = self.refused or f"a reference to something outside the file ({pid!r:.60})"
        raise pickle.UnpicklingError("a persistent id")
