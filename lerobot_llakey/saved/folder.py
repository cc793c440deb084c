"""A checkpoint's folder: found on this disk or the Hub, and looked over before a library reads anything of it."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path
from typing import Any

from huggingface_hub import snapshot_download
from huggingface_hub.constants import CONFIG_NAME, SAFETENSORS_SINGLE_FILE
from huggingface_hub.errors import HFValidationError
from lerobot.utils.constants import POLICY_POSTPROCESSOR_DEFAULT_NAME, POLICY_PREPROCESSOR_DEFAULT_NAME
from safetensors import safe_open

from lerobot_llakey.errors import LlakeyError, MissingFileError, said
from lerobot_llakey.files import reading
from lerobot_llakey.saved.own import is_hub_name
from lerobot_llakey.saved.processors import check_steps

DOWNLOAD = ("revision", "cache_dir", "force_download", "token", "local_files_only")
"""Options of LeRobot's ``from_pretrained`` that say how a Hub repository is fetched."""
PROCESSORS = tuple(f"{name}.json" for name in (POLICY_PREPROCESSOR_DEFAULT_NAME, POLICY_POSTPROCESSOR_DEFAULT_NAME))
FILES = ("*.json", "*.safetensors", "language_model/*")
"""What of a Hub repository is fetched, and so what is sent there; in the folder are a language model's architecture and
processor."""
_MOST_BYTES = 100_000_000
"""Of a JSON file: a tokenizer's vocabulary is the largest."""


def find_checkpoint(path: str | Path, **options: Any) -> Path:
    """The folder of a checkpoint, fetched where it is on the Hub alone.

    Args:
        path: a folder or a Hub name.
        **options: of ``snapshot_download``, such as ``revision``.

    Raises:
        MissingFileError: if there is no such folder and it cannot be a Hub name.
        LlakeyError: if it is a file, or cannot be fetched from the Hub.
    """
    folder = Path(path)
    if folder.is_dir():
        return folder
    if folder.exists() or folder.is_symlink():
        raise LlakeyError(f"Expected a checkpoint folder or a Hub name, got {path}, which is no folder; correct it.")
    name = str(path)
    # A first part that is a folder here is meant as one: outputs/llakey, checkpoints/llakey_small.
    if not is_hub_name(name) or "/" not in name or Path(name).parent.is_dir():
        raise MissingFileError(
            f"Expected a checkpoint folder or a Hub name, got {name}, where none was found; check the path."
        )
    try:
        return Path(snapshot_download(name, **{"allow_patterns": list(FILES)} | options))
    except (OSError, ValueError, HFValidationError) as error:
        raise LlakeyError(
            f"Expected a checkpoint folder or a Hub name, got {name}: no folder here, and the Hub does not give it "
            f"({type(error).__name__}: {said(error, 160)}); check the name, the network and your access."
        ) from error


def inspect_checkpoint(path: str | Path, steps: frozenset[str] | None = None, **options: Any) -> Path:
    """Find a checkpoint and look it over: what LeRobot will read is whole, and names nothing that could run.

    Args:
        path: a folder or a Hub name.
        steps: names of the processor steps that it may have; None takes any registered one.
        **options: of ``snapshot_download``, such as ``revision``.

    Returns:
        Its folder.

    Raises:
        MissingFileError: if there is none.
        LlakeyError: naming the file that is broken, or that names what no checkpoint may.
    """
    folder = find_checkpoint(path, **options)
    try:
        present = sorted(folder.iterdir())
    except OSError as error:
        raise LlakeyError(f"Expected a checkpoint folder that can be read, got {folder} ({error.strerror}).") from error
    read_settings(folder)
    for file in present:
        if file.suffix in (".json", ".safetensors"):
            require_file(file)
    for name in PROCESSORS:
        if (folder / name).exists():
            check_steps(folder / name, read_json(folder / name), steps)
    for file in present:
        if file.suffix == ".safetensors":
            with reading(file, "safetensors file"), safe_open(file, framework="pt"):
                pass
    return folder


def read_settings(folder: Path) -> dict[str, Any]:
    """What a checkpoint's ``config.json`` holds, with the policy's ``type``.

    Raises:
        LlakeyError: if it is missing, broken or names no type.
    """
    settings = read_json(folder / CONFIG_NAME, "checkpoint's settings")
    if not isinstance(settings.get("type"), str):
        raise LlakeyError(
            f"Expected the type of a policy in {folder / CONFIG_NAME}, got {settings.get('type')!r}; give a checkpoint "
            "folder, such as .../checkpoints/last/pretrained_model."
        )
    return settings


def read_json(file: Path, kind: str = "JSON file") -> dict[str, Any]:
    """The object that a JSON file holds.

    Raises:
        LlakeyError: if it is missing, no regular file, too large, broken, or holds something else.
    """
    if not file.exists() and file.parent.is_dir():
        raise MissingFileError(
            f"Expected a checkpoint with {file.name} in {file.parent}, got a folder without it; give one that a "
            "training run saved, such as .../checkpoints/last/pretrained_model."
        )
    require_file(file)
    if file.stat().st_size > _MOST_BYTES:
        raise LlakeyError(f"Expected at most {_MOST_BYTES // 10**6} MB in {file}, got {file.stat().st_size} bytes.")
    with reading(file, kind):
        content = json.loads(file.read_text(encoding="utf-8"))
    if not isinstance(content, dict):
        raise LlakeyError(f"Expected an object in {file}, got {type(content).__name__}; fetch or make it anew.")
    return content


def require_file(file: Path) -> None:
    """Refuse a folder, a named pipe or a device where a file is to be read: a pipe would block for ever.

    Raises:
        LlakeyError: naming it.
    """
    with reading(file):
        mode = os.stat(file).st_mode
    if not stat.S_ISREG(mode):
        kind = "folder" if stat.S_ISDIR(mode) else "named pipe" if stat.S_ISFIFO(mode) else "device"
        raise LlakeyError(f"Expected a file at {file}, got a {kind}; fetch or make the checkpoint anew.")


def require_weights(folder: Path) -> Path:
    """The file of a policy's weights.

    Raises:
        MissingFileError: if it is not there.
        LlakeyError: if it is no file.
    """
    file = folder / SAFETENSORS_SINGLE_FILE
    if not file.exists():
        raise MissingFileError(
            f"Expected a checkpoint with the weights {file}, got a folder without them; fetch or make it anew."
        )
    require_file(file)
    return file
