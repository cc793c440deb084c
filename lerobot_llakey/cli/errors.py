"""What a person sees of an error that is theirs to mend: its one sentence, without a traceback."""

from __future__ import annotations

import errno
import sys
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from draccus.utils import ParsingError

from lerobot_llakey.errors import LlakeyError, said
from lerobot_llakey.files import reason


@contextmanager
def one_sentence() -> Iterator[None]:
    """Turn errors about input into one sentence on stderr and exit status 1; all others keep their traceback.

    Raises:
        SystemExit: in place of a :class:`LlakeyError`, a setting that cannot be read, a refusal of the file system, or
            a process of several that was killed.
    """
    try:
        yield
    except (LlakeyError, ParsingError, OSError, BrokenProcessPool) as error:
        sentence = _sentence(error)
        if sentence is None:
            raise
        print(f"error: {sentence}", file=sys.stderr)
        raise SystemExit(1) from error


def _sentence(error: BaseException) -> str | None:
    """What to say of an error; None for a fault of the program."""
    cause: BaseException | None = error
    while isinstance(cause, ParsingError) and cause.__cause__ is not None:
        cause = cause.__cause__  # draccus wraps errors raised while settings are read
    if isinstance(cause, LlakeyError):
        return str(cause)
    if isinstance(cause, OSError) and cause.errno is not None and cause.filename is not None:
        places = " and ".join(str(name) for name in (cause.filename, cause.filename2) if name is not None)
        return f"Expected to read or write {places}, got refused ({reason(cause)}); check the path and its permissions."
    if isinstance(cause, OSError) and cause.errno in (errno.ENOSPC, errno.EDQUOT):  # parquet's writer names no file
        return f"Expected enough space to write, got refused ({reason(cause)}); free some and run it again."
    if isinstance(cause, BrokenProcessPool):
        return "Expected all processes to end well, got one killed, perhaps for want of memory; lower --num_workers."
    if isinstance(error, ParsingError):
        return f"Expected options that can be read, got one that cannot ({said(cause)}); correct it."
    return None
