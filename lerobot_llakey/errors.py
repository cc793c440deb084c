"""The error of this package for whatever its user can mend: one sentence, shown without a traceback.

Its text says what was expected, what came, and what to do. Any other exception is a fault of the program.
"""


class LlakeyError(ValueError):
    """Something handed in is wrong: data, a checkpoint, a setting, a server, a second process."""


class MissingFileError(LlakeyError, FileNotFoundError):
    """A file or folder was expected and none is there."""


class FileInTheWayError(LlakeyError, FileExistsError):
    """A file or folder stands where a new one is to be written."""


def said(error: object, longest: int | None = None) -> str:
    """What an error of a library says, on one line and cut after ``longest`` characters, to be quoted in a sentence."""
    return " ".join(str(error).split())[:longest]
