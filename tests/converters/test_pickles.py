"""Pickles give numbers and plain containers; none of their code runs, and broken ones are refused in one sentence."""

import pickle
import pickletools
from collections import OrderedDict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fakes_rlbench import stand_in_modules
from lerobot_llakey.converters.pickles import read_pickle
from lerobot_llakey.errors import LlakeyError, MissingFileError


def written(tmp_path: Path, content: Any, protocol: int = 4) -> Path:
    path = tmp_path / "some.pkl"
    path.write_bytes(content if isinstance(content, bytes) else pickle.dumps(content, protocol))
    return path


@pytest.mark.parametrize("protocol", range(2, 6))
def test_numbers_come_back_whatever_the_protocol(tmp_path: Path, protocol: int) -> None:
    content = {"a": np.arange(6.0).reshape(2, 3), "b": np.float32(2), "c": [1, "two", b"\xff", None], "d": np.array(3)}
    found = read_pickle(written(tmp_path, content, protocol))
    assert np.array_equal(found["a"], content["a"]) and found["b"] == 2 and found["c"] == content["c"]
    assert found["d"] == 3


@pytest.mark.parametrize("core", [b"numpy.core.multiarray", b"numpy._core.multiarray"])
def test_arrays_of_both_numpys_are_read(tmp_path: Path, core: bytes) -> None:
    content = pickle.dumps(np.arange(3), 2)
    assert b"numpy._core.multiarray" in content
    assert read_pickle(written(tmp_path, content.replace(b"numpy._core.multiarray", core))).tolist() == [0, 1, 2]


def test_rlbenchs_objects_become_plain_containers(tmp_path: Path) -> None:
    with stand_in_modules() as (demo, observation):
        made, inside = demo(), observation()
        inside.gripper_open = 1.0
        made._observations = [inside]
        path = written(tmp_path, made)
    found = read_pickle(path)
    assert type(found).__name__ == "Demo" and found._observations[0].gripper_open == 1.0
    assert type(found) is not type(read_pickle(path)), "nothing is shared between files"


class Harmful:
    """Touches a file when it is unpickled by Python's own loader."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return exec, (f"open({self.path!r}, 'w').close()",)


def test_code_in_a_pickle_does_not_run(tmp_path: Path) -> None:
    touched = tmp_path / "touched"
    path = written(tmp_path, [np.arange(3), Harmful(str(touched))])
    with pytest.raises(LlakeyError, match=r"got builtins\.exec; it is not read"):
        read_pickle(path)
    assert not touched.exists()
    pickle.loads(path.read_bytes())
    assert touched.exists(), "the pickle is harmful indeed"


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (b"cos\nsystem\n(S'true'\ntR.", "os.system"),
        (b"cnumpy.testing\nassert_equal\n.", "numpy.testing.assert_equal"),
        (b"cnumpy\nload\n(S'x'\ntR.", "numpy.load"),
        (b"\x80\x04\x8c\x08builtins\x8c\x07getattr\x93.", "builtins.getattr"),
        # A dotted name would walk from an admitted module to anything that it imports.
        (b"\x80\x04\x8c\x05numpy\x8c\x15ndarray.__reduce_ex__\x93.", "numpy.ndarray.__reduce_ex__"),
        (b"Pouter\n.", "a reference to something outside the file"),
        (OrderedDict(a=1), "collections.OrderedDict"),
    ],
)
def test_a_name_outside_the_list_is_refused_by_name(tmp_path: Path, content: Any, named: str) -> None:
    with pytest.raises(LlakeyError, match="it could run code") as error:
        read_pickle(written(tmp_path, content))
    assert named in str(error.value)


def test_what_a_pickle_sets_on_a_class_stays_in_its_file(tmp_path: Path) -> None:
    # BUILD with a pair sets attributes on the class itself.
    content = b"\x80\x04\x8c\x0crlbench.demo\x8c\x04Demo\x93N}\x8c\x04evilK\x01s\x86b."
    pickletools.dis(content, out=(tmp_path / "listing").open("w"))
    assert read_pickle(written(tmp_path, content)).evil == 1
    with stand_in_modules() as (demo, _):
        path = written(tmp_path, demo())
    assert not hasattr(read_pickle(path), "evil")


def test_every_cut_is_refused(tmp_path: Path) -> None:
    whole = pickle.dumps({"a": np.arange(9.0), "b": ["text"] * 3}, 4)
    for end in range(0, len(whole) - 1, 3):
        with pytest.raises(LlakeyError):
            read_pickle(written(tmp_path, whole[:end]))


def test_flipped_bytes_never_run_anything_else(tmp_path: Path) -> None:
    whole = bytearray(pickle.dumps({"a": np.arange(9.0), "b": ["text"] * 3}, 4))
    rng = np.random.default_rng(0)
    refused = 0
    for _ in range(150):
        broken = bytearray(whole)
        broken[rng.integers(len(whole))] ^= 1 << rng.integers(8)
        try:
            read_pickle(written(tmp_path, bytes(broken)))
        except LlakeyError:
            refused += 1
    assert refused > 50


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"none\.pkl"):
        read_pickle(tmp_path / "none.pkl")
