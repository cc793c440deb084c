"""What a person sees of an error that is theirs to mend: its one sentence, without a traceback."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from draccus.utils import ParsingError


@contextmanager
def one_sentence() -> Iterator[None]:
    """Turn errors about input into their message on stderr and exit status 1; all others keep their traceback.

    Raises:
        SystemExit: in place of ValueError, FileNotFoundError, FileExistsError and RuntimeError raised by this package.
    """
    try:
        yield
    except (ValueError, FileNotFoundError, FileExistsError, RuntimeError, ParsingError) as error:
        said = _cause(error)
        if not str(said).startswith("Expected "):
            raise
        print(f"error: {said}", file=sys.stderr)
        raise SystemExit(1) from error


def _cause(error: BaseException) -> BaseException:
    """The error behind those that draccus wraps around one raised while settings are read from a file."""
    while isinstance(error, ParsingError) and error.__cause__ is not None:
        error = error.__cause__
    return error
