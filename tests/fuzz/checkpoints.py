"""Checkpoints that are broken, of strangers, or hold weights that cannot act."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import load_file, save_file

from fuzz.case import Case

Change = Callable[[Path], None]
"""What is done to a whole checkpoint's folder."""

WEIGHTS, CONFIG, BEFORE, AFTER = (
    "model.safetensors",
    "config.json",
    "policy_preprocessor.json",
    "policy_postprocessor.json",
)


def _load(source: Path, change: Change, folder: Path) -> None:
    """As every verb loads a checkpoint, then once as a program does."""
    from lerobot_llakey.rollout.actors import Agent

    copied = folder / "checkpoint"
    shutil.copytree(source, copied)
    change(copied)
    Agent.load(copied)


def _planted(source: Path, change: Change, folder: Path) -> str | None:
    """What a stranger planted must do nothing: it is refused, or ignored."""
    proof = folder / "proof"
    os.environ["PLANTED_PROOF"] = str(proof)
    copied = folder / "checkpoint"
    shutil.copytree(source, copied)
    change(copied)
    for path in copied.glob("*.json"):
        path.write_text(path.read_text().replace("PROOF", str(proof)))
    from lerobot_llakey.rollout.actors import Agent

    try:
        agent = Agent.load(copied)
        config = agent.policy.config
        log_dir = getattr(config, "log_dir", None)
        return "right" if not proof.exists() and log_dir is None else None
    finally:
        assert not proof.exists(), "what was planted ran"


def _tensors(change: Callable[[dict[str, torch.Tensor]], Any]) -> Change:
    def apply(folder: Path) -> None:
        tensors = load_file(folder / WEIGHTS)
        change(tensors)
        save_file(tensors, folder / WEIGHTS)

    return apply


def _json(name: str, change: Callable[[Any], Any]) -> Change:
    def apply(folder: Path) -> None:
        content = json.loads((folder / name).read_text())
        content = change(content) or content
        (folder / name).write_text(json.dumps(content))

    return apply


def _bytes(name: str, change: Callable[[bytes], bytes]) -> Change:
    return lambda folder: (folder / name).write_bytes(change((folder / name).read_bytes())) and None


def _instead(name: str, make: Callable[[Path], Any]) -> Change:
    def apply(folder: Path) -> None:
        (folder / name).unlink()
        make(folder / name)

    return apply


def _value(key: str, value: Any) -> Callable[[dict[str, torch.Tensor]], None]:
    def change(tensors: dict[str, torch.Tensor]) -> None:
        changed = tensors[key].clone()
        changed.view(-1)[0] = value
        tensors[key] = changed

    return change


def _replaced(key: str, make: Callable[[torch.Tensor], torch.Tensor]) -> Callable[[dict[str, torch.Tensor]], None]:
    def change(tensors: dict[str, torch.Tensor]) -> None:
        tensors[key] = make(tensors[key]).contiguous()

    return change


def write_checkpoint(folder: Path) -> Path:
    """A saved hierarchy of two tiny policies, with its processors."""
    from fuzz.batches import _policy
    from lerobot_llakey.policies.hierarchy.compose import save

    policy = _policy("hierarchy")
    save(policy, folder)
    return folder


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Weights, settings and processors, wrong in turn."""
    source = write_checkpoint(folder / "whole")
    tensors = load_file(source / WEIGHTS)
    floats = sorted(key for key, value in tensors.items() if value.is_floating_point() and value.numel() > 8)
    for key in rng.choice(floats, size=min(24, len(floats)), replace=False):
        for name, value in (("NaN", float("nan")), ("inf", float("inf"))):
            yield _case(f"{name} in {key}", source, _tensors(_value(key, value)), (key,))
    for key in rng.choice(floats, size=min(12, len(floats)), replace=False):
        for name, make in {
            "int8": lambda value: value.to(torch.int8),
            "bool": lambda value: value.bool(),
            "one longer": lambda value: torch.cat((value, value[:1])),
            "transposed and cut": lambda value: value.flatten()[:3],
        }.items():
            yield _case(f"{key} {name}", source, _tensors(_replaced(key, make)), (key, WEIGHTS))
        yield _case(f"{key} missing", source, _tensors(lambda found, key=key: found.pop(key)), (key,))
    yield _case(
        "all zero", source, _tensors(lambda found: found.update({key: value * 0 for key, value in found.items()}))
    )
    yield _case("a tensor more", source, _tensors(lambda found: found.update(extra=torch.ones(3))), ("extra",))
    for name in (WEIGHTS, CONFIG, BEFORE, AFTER):
        for part in (0, 1, 7, 100, 1_000_000):
            if part < (source / name).stat().st_size:
                yield _case(
                    f"{name} cut to {part} bytes", source, _bytes(name, lambda data, part=part: data[:part]), (name,)
                )
        for change, said in (
            (lambda data: b"\xff\xfe" + data, "with a foreign mark"),
            (lambda data: data[:3] + b"\x00\x01\x02\x03" + data[7:], "flipped"),
            (lambda data: b"[]", "of brackets"),
            (lambda data: b"null", "of null"),
            (lambda data: b"[" * 100_000, "of 100,000 brackets"),
        ):
            yield _case(f"{name} {said}", source, _bytes(name, change), (name,))
        yield _case(f"{name} missing", source, lambda place, name=name: (place / name).unlink(), (name, "checkpoint"))
        yield _case(f"{name} a folder", source, _instead(name, Path.mkdir), (name, "checkpoint"))
        yield _case(f"{name} a named pipe", source, _instead(name, lambda path: os.mkfifo(path)), (name, "checkpoint"))
        yield _case(
            f"{name} a dangling link",
            source,
            _instead(name, lambda path: path.symlink_to("/no/where")),
            (name, "checkpoint"),
        )
    for key, value in {
        "type": "no_such", "command": 7, "action": [], "seed": "zero", "repeat_threshold": -1, "commander": None,
        "no_such_setting": 1, "input_features": "all", "random_move_radius": float("nan"), "instructions": 3,
    }.items():  # fmt: skip
        yield _case(
            f"{CONFIG}: {key} is {value}",
            source,
            _json(CONFIG, lambda held, key=key, value=value: held.update({key: value})),
            (key, CONFIG),
        )
    for part, key, value in (
        ("action", "crop_size", -0.2), ("action", "crop_size", 1e9), ("action", "workspace", [[0, 1]]),
        ("action", "cameras", ["front", "front", "wrist", "wrist"]), ("action", "views", []), ("action", "widths", [1]),
        ("command", "words", []), ("command", "words", ["b", "a"]), ("command", "instructions", [3]),
        ("command", "max_new_tokens", 0), ("command", "image_size", 33), ("action", "text_buckets", 3),
    ):  # fmt: skip
        change = _json(CONFIG, lambda held, part=part, key=key, value=value: held[part].update({key: value}))
        yield _case(f"{CONFIG}: {part}.{key} is {value}", source, change, (key, CONFIG, WEIGHTS))
    programs = (
        {"class": "subprocess.Popen", "config": {"args": ["touch", "PROOF"]}},
        {"class": "os.system", "config": {"command": "touch PROOF"}},
    )
    for name in (BEFORE, AFTER):
        for step in programs:
            change = _step(name, step)
            yield Case("checkpoint", f"{name}: a step of {step['class']}", partial(_planted, source, change))
        unknown = {"registry_name": "no_such", "config": {}}
        yield _case(f"{name}: an unknown step", source, _step(name, unknown), ("no_such", name))
        outside = {"registry_name": "device_processor", "config": {}, "state_file": "../../secret.safetensors"}
        yield _case(f"{name}: a state file outside", source, _step(name, outside), (name, "secret"))
    change = _json(CONFIG, lambda held: held.update(log_dir="PROOF"))
    yield Case("checkpoint", "a log folder of its own", partial(_planted, source, change))
    for gone in ("nowhere", "/no/such/folder", "no/such/checkpoint/here"):
        yield Case("checkpoint", f"no folder {gone}", partial(_missing, gone), (gone,))


def _zero(tensors: dict[str, torch.Tensor]) -> None:
    for key, value in tensors.items():
        tensors[key] = value * 0


def _step(name: str, step: dict[str, Any]) -> Change:
    return _json(name, lambda held: held["steps"].insert(0, step))


def _missing(path: str, _: Path) -> None:
    from lerobot_llakey.rollout.actors import Agent

    Agent.load(path)


def _case(name: str, source: Path, change: Change, names: tuple[str, ...] = ()) -> Case:
    return Case("checkpoint", name, partial(_load, source, change), names)
