"""Puts this package's look at a checkpoint before LeRobot's reading of its settings.

LeRobot parses a checkpoint's settings together with the command line's, in functions of its own base classes, and
calls nothing of the policy's class on the way: once the settings are an object, who said what is lost. So these
functions are wrapped here, for this package's types of policies alone.
"""

from __future__ import annotations

import functools
import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import draccus
from huggingface_hub import hf_hub_download
from huggingface_hub.constants import CONFIG_NAME
from huggingface_hub.errors import HfHubHTTPError
from lerobot.configs import PreTrainedConfig, parser
from lerobot.configs.train import (
    PRETRAINED_MODEL_DIR,
    TRAIN_CONFIG_NAME,
    TrainPipelineConfig,
    find_latest_hub_checkpoint,
)

from lerobot_llakey.errors import LlakeyError, MissingFileError
from lerobot_llakey.files import reading
from lerobot_llakey.saved.folder import DOWNLOAD, find_checkpoint, inspect_checkpoint, read_json, read_settings
from lerobot_llakey.saved.own import is_hub_name, without_own
from lerobot_llakey.saved.processors import OUR_STEPS


def guard_loading(package: str) -> None:
    """Wrap LeRobot's ``from_pretrained`` of policies' and of training runs' settings; a second call does nothing.

    Args:
        package: whose policies are guarded.
    """
    for owner, wrap in ((PreTrainedConfig, _policy_settings), (TrainPipelineConfig, _run_settings)):
        original: Any = owner.__dict__["from_pretrained"].__func__
        if not hasattr(original, "guards"):
            wrapped = functools.wraps(original)(wrap(original, package))
            wrapped.guards = package  # type: ignore[attr-defined]
            owner.from_pretrained = classmethod(wrapped)


def _policy_settings(original: Callable[..., Any], package: str) -> Callable[..., Any]:
    def from_pretrained(cls: type, pretrained_name_or_path: str | Path, **kwargs: Any) -> Any:
        options = {name: kwargs[name] for name in DOWNLOAD if kwargs.get(name) is not None}
        folder = find_checkpoint(pretrained_name_or_path, allow_patterns=["*.json"], **options)
        settings = read_settings(folder)
        guarded = _guarded(settings["type"], package)
        if guarded is None:
            return original(cls, pretrained_name_or_path, **kwargs)
        inspect_checkpoint(folder, OUR_STEPS)
        given = kwargs.get("cli_overrides") or []
        without_own(guarded, settings, folder, given)
        with tempfile.TemporaryDirectory() as cleaned, _named(folder / CONFIG_NAME):
            (Path(cleaned) / CONFIG_NAME).write_text(json.dumps(settings), encoding="utf-8")
            return original(cls, cleaned, **kwargs)

    return from_pretrained


def _run_settings(original: Callable[..., Any], package: str) -> Callable[..., Any]:
    def from_pretrained(cls: type, pretrained_name_or_path: str | Path, **kwargs: Any) -> Any:
        named = parser.parse_arg("config_path") or str(pretrained_name_or_path)
        if _is_saved(named) and parser.get_path_arg("policy", []):
            raise LlakeyError(
                f"Expected settings of a training run in {named}, got some with a policy.path, which no run saves; "
                "give --policy.path yourself."
            )
        if not _is_saved(str(pretrained_name_or_path)):
            return original(cls, pretrained_name_or_path, **kwargs)
        file = _run_file(pretrained_name_or_path, kwargs)
        settings = read_json(file, "training run's settings")
        policy = settings.get("policy")
        guarded = _guarded(policy.get("type"), package) if isinstance(policy, dict) else None
        if guarded is None or not isinstance(policy, dict):
            return original(cls, pretrained_name_or_path, **kwargs)
        given = [f"--{argument.removeprefix('--policy.')}" for argument in kwargs.get("cli_args") or []]
        without_own(guarded, policy, file.parent, given)
        with tempfile.TemporaryDirectory() as cleaned, _named(file):
            (Path(cleaned) / file.name).write_text(json.dumps(settings), encoding="utf-8")
            return original(cls, Path(cleaned) / file.name, **kwargs)

    return from_pretrained


def _run_file(path: str | Path, options: dict[str, Any]) -> Path:
    """The settings of a training run, where LeRobot looks for them: in a folder, a file, or on the Hub."""
    place = Path(path)
    if place.exists():
        return place / TRAIN_CONFIG_NAME if place.is_dir() else place
    wanted = {name: options[name] for name in DOWNLOAD if options.get(name) is not None}
    try:
        return Path(hf_hub_download(str(path), TRAIN_CONFIG_NAME, **wanted))
    except HfHubHTTPError as error:  # the repository of a run that was interrupted holds checkpoints alone
        latest = find_latest_hub_checkpoint(str(path), token=wanted.get("token"), revision=wanted.get("revision"))
        if latest is None:
            raise MissingFileError(f"Expected {TRAIN_CONFIG_NAME} in {path}, got none; check the name.") from error
        return Path(hf_hub_download(str(path), f"{latest}/{PRETRAINED_MODEL_DIR}/{TRAIN_CONFIG_NAME}", **wanted))


def _is_saved(path: str) -> bool:
    """Whether a run's settings are those of a checkpoint rather than a file of the user's own."""
    return Path(path).is_dir() or Path(path).name == TRAIN_CONFIG_NAME or is_hub_name(path)


def _guarded(kind: Any, package: str) -> type | None:
    """The settings' class of a type of policy, where it is this package's."""
    found = PreTrainedConfig.get_known_choices().get(kind) if isinstance(kind, str) else None
    return found if found is not None and found.__module__.partition(".")[0] == package else None


@contextmanager
def _named(file: Path) -> Iterator[None]:
    """Say in which file settings are wrong that LeRobot's parser refuses."""
    try:
        with reading(file, "file of settings"):
            try:
                yield
            except draccus.utils.DraccusException as error:
                cause: BaseException | None = error
                while cause is not None and not isinstance(cause, LlakeyError):
                    cause = cause.__cause__
                if cause is None:
                    raise
                raise LlakeyError(f"{cause} It came up in {file} with the command line's options.") from error
    except RuntimeError as error:
        raise LlakeyError(f"Expected settings that can be read in {file}, got some that cannot ({error}).") from error
