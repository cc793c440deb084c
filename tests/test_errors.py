"""The package's own errors."""

import pickle

import pytest

from lerobot_llakey.errors import FileInTheWayError, LlakeyError, MissingFileError, said


@pytest.mark.parametrize(
    ("kind", "others"),
    [
        (LlakeyError, (ValueError,)),
        (MissingFileError, (LlakeyError, FileNotFoundError)),
        (FileInTheWayError, (LlakeyError, FileExistsError)),
    ],
)
def test_each_is_caught_as_pythons_own_and_passes_between_processes(
    kind: type[LlakeyError], others: tuple[type[Exception], ...]
) -> None:
    error = pickle.loads(pickle.dumps(kind("Expected a cup, got a glass; take a cup.")))
    assert type(error) is kind and str(error) == "Expected a cup, got a glass; take a cup."
    for other in others:
        assert isinstance(error, other)


def test_a_librarys_words_are_quoted_on_one_line_and_cut() -> None:
    error = RuntimeError("CUDA error:\n  no device\t here ")
    assert said(error) == "CUDA error: no device here"
    assert said(error, 10) == "CUDA error"
