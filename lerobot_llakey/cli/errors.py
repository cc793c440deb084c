"""What a person sees of an error that is theirs to mend: its one sentence, without a traceback."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_sentence() -> Iterator[None]:
    """Turn errors about input into their message on stderr and exit status 1; all others keep their traceback.

    Raises:
        SystemExit: in place of ValueError, FileNotFoundError, FileExistsError and RuntimeError raised by this package.
    """
    try:
        yield
    except (ValueError, FileNotFoundError, FileExistsError, RuntimeError) as error:
        if not str(error).startswith("Expected "):
            raise
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(1) from error
