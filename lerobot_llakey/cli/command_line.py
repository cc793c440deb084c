"""From a command line to a verb's options: what LeRobot's ``parser.wrap`` does, with one sentence for what is wrong."""

from __future__ import annotations

import sys
from argparse import ArgumentError
from collections.abc import Callable, Sequence
from dataclasses import fields
from difflib import get_close_matches
from functools import wraps
from pathlib import Path
from typing import Any, get_type_hints

import draccus
import yaml
from draccus.utils import DraccusException
from lerobot.configs import parser

from lerobot_llakey.cli.options import check_options
from lerobot_llakey.errors import LlakeyError, said
from lerobot_llakey.files import reading

_FILE_OPTION = "config_path"


def with_options[Result](run: Callable[[Any], Result]) -> Callable[..., Result]:
    """Let a function whose one argument is a dataclass of options take them from the command line.

    Given such a dataclass it takes that instead. Either way they are held against :data:`RULES` first.
    """
    kind = next(hint for name, hint in get_type_hints(run).items() if name != "return")

    @wraps(run)
    def parsed(config: Any = None) -> Result:
        config = parse(kind, sys.argv[1:]) if config is None else config
        check_options(config)
        return run(config)

    return parsed


def parse(kind: type, arguments: Sequence[str]) -> Any:
    """Read a dataclass of options.

    Args:
        kind: the dataclass.
        arguments: of the command line; those of ``--config_path=FILE.yaml`` stand behind all others.

    Raises:
        LlakeyError: if one is unknown, missing or of another type, or the file cannot be read.
        SystemExit: after ``--help`` (status 0).
    """
    if {"--help", "-h"} & set(arguments):
        parser.print_scoped_help(kind, arguments)
        raise SystemExit(0)
    _refuse_unknown(kind, arguments)
    file = parser.parse_arg(_FILE_OPTION, arguments)
    rest = parser.filter_arg(_FILE_OPTION, arguments)
    try:
        if file is None:
            return draccus.parse(kind, args=rest, exit_on_error=False)
        with reading(Path(file), "YAML file of options"):
            return draccus.parse(kind, file, args=rest, exit_on_error=False)
    except (DraccusException, ArgumentError, yaml.YAMLError) as error:
        raise _refused(error) from error


def _refused(error: BaseException) -> LlakeyError:
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, LlakeyError):
        cause = cause.__cause__  # draccus wraps errors raised while settings are read
    return cause or LlakeyError(
        f"Expected options that can be read, got one that cannot ({said(error, 400)}); see --help."
    )


def _refuse_unknown(kind: type, arguments: Sequence[str]) -> None:
    known = [part.name for part in fields(kind)]
    for argument in arguments:
        option, _, _ = argument.partition("=")
        name = option.removeprefix("--").partition(".")[0]
        if option.startswith("--") and name not in (*known, _FILE_OPTION):
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean --{near[0]}?" if near else "see --help."
            raise LlakeyError(f"Expected options out of {', '.join(known)}, got {option!r}; {hint}")
