"""Batches that break the data contract, for training and for acting, with all three policies."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch

from fuzz.case import Case
from lerobot_llakey import schema

ROWS = 2


@cache
def _policy(kind: str) -> Any:
    from fakes_action import small_config
    from lerobot_llakey.instructions import BASIC_GRAMMAR
    from lerobot_llakey.policies.action.modeling_llakey_action import LlakeyActionPolicy
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
    from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
    from lerobot_llakey.policies.command.small.tokenizer import grammar_words, known_words
    from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
    from lerobot_llakey.policies.hierarchy.modeling_llakey import LlakeyPolicy

    torch.manual_seed(0)
    if kind == "action":
        return LlakeyActionPolicy(small_config())
    known = [f"grasp the {colour} block" for colour in ("red", "green", "blue", "yellow")]
    command = LlakeyCommandConfig(
        device="cpu", image_size=32, patch_size=16, vision_width=16, vision_layers=1, vision_heads=2, text_width=32,
        text_layers=1, text_heads=2, instructions=known, proprioception="pose",
        cameras=list(schema.CAMERAS), state_names=list(schema.SIM_STATE_NAMES),
        workspace=[list(bounds) for bounds in schema.WORKSPACE],
        words=sorted({*grammar_words(BASIC_GRAMMAR), *known_words([*known, "pick up the red block"])}),
    )  # fmt: skip
    if kind == "command":
        return LlakeyCommandPolicy(command)
    return LlakeyPolicy(LlakeyConfig(command=command, action=small_config(), device="cpu"))


@cache
def _batch() -> dict[str, Any]:
    from fakes_action import observation

    batch, _, _ = observation(ROWS)
    return batch | {schema.PREVIOUS_INSTRUCTION: [""] * ROWS, schema.STEP: torch.zeros(ROWS, 1)}


def _copy(batch: dict[str, Any]) -> dict[str, Any]:
    return {key: value.clone() if isinstance(value, torch.Tensor) else list(value) for key, value in batch.items()}


def _hand_in(kind: str, use: str, change: Callable[[dict[str, Any]], Any], right: bool, _: Path) -> str | None:
    policy, batch = _policy(kind), _copy(_batch())
    change(batch)
    train = use == "train"
    policy.train(train)
    policy.reset()

    def result(given: dict[str, Any]) -> Any:
        torch.manual_seed(0)
        if train:
            return policy.eval().forward(given)[0].detach()
        policy.reset()
        if kind == "command":
            return policy.answer(given)[0].text
        return policy.select_action(given)

    found = result(batch)
    if not right:
        return None
    reference = _copy(_batch())
    if (
        isinstance(changed := batch.get(schema.depth_key("front")), torch.Tensor)
        and len(changed.nan_to_num().unique()) <= 1
    ):
        reference[schema.depth_key("front")].zero_()  # nothing was measured
    wanted = result(reference)
    alike = torch.allclose(found, wanted, atol=1e-4) if isinstance(wanted, torch.Tensor) else found == wanted
    return "right" if alike else None


@dataclass(frozen=True)
class Fault:
    """What is wrong with one key of a batch.

    Attributes:
        key: of the batch.
        what: is wrong with it.
        change: makes it so, in place.
        policies: that read it so.
        uses: "train", "act" or both.
        right: it may be put right in place of being refused.
    """

    key: str
    what: str
    change: Callable[[dict[str, Any]], Any]
    policies: tuple[str, ...]
    uses: tuple[str, ...]
    right: bool = False


EVERYONE, SEEING, SPEAKING = ("action", "command", "hierarchy"), ("action", "hierarchy"), ("command", "hierarchy")
TRAINED, USED, BOTH = ("train",), ("act",), ("train", "act")
_LAST = (ROWS - 1,)
_RED = "grasp the red block"


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Each fault, for each policy that reads what it is in, in training and in acting."""
    for policy in EVERYONE:
        _policy(policy)  # made once, before the cases part into processes of their own
    for faults in (_numbers, _pictures, _calibration, _absent, _weights_and_texts):
        for fault in faults():
            for policy, use in product(fault.policies, fault.uses):
                act = partial(_hand_in, policy, use, fault.change, fault.right)
                names = (fault.key, fault.key.rpartition(".")[2], *_NAMES.get(fault.key, ()))
                yield Case("batch", f"{use} {policy}: {fault.key} {fault.what}", act, names)


def _numbers() -> Iterator[Fault]:
    parts = {"position": schema.POSITION, "quaternion": schema.QUATERNION, "gripper": schema.GRIPPER}
    for key, policies, uses in ((schema.STATE, EVERYONE, BOTH), (schema.ACTION, SEEING, TRAINED)):
        for value, (part, where) in product((math.nan, math.inf, -math.inf), parts.items()):
            yield Fault(key, f"{part} {value}", _set(key, (*_LAST, where), value), policies, uses)
        for factor, what in ((0.0, "zero"), (1e-20, "tiny"), (100.0, "of length 100")):
            change = _map(key, partial(_scaled, part=schema.QUATERNION, factor=factor))
            yield Fault(key, f"quaternion {what}", change, SEEING, uses)
        millimetres = _map(key, partial(_scaled, part=schema.POSITION, factor=1000))
        yield Fault(key, "millimetres", millimetres, SEEING, uses)
        yield Fault(key, "too short", _map(key, lambda value: value[:, :6]), SEEING, TRAINED)
    for value in (255.0, -1.0, 100.0):
        change = _set(schema.ACTION, (*_LAST, schema.GRIPPER), value)
        yield Fault(schema.ACTION, f"gripper {value}", change, SEEING, TRAINED)


def _pictures() -> Iterator[Fault]:
    image, depth = schema.image_key("front"), schema.depth_key("front")
    for what, function in {
        "metres": lambda value: value / 1000,
        "rows short": lambda value: value[:1],
        "another size": lambda value: value[..., :16],
        "three channels": lambda value: value.expand(-1, 3, -1, -1),
        "no numbers": lambda value: ["depth"] * ROWS,
    }.items():
        yield Fault(depth, what, _map(depth, function), SEEING, BOTH)
    for value in (math.nan, math.inf, -math.inf, -500.0, 0.0, 65535.0):
        # What is not measured may come in any of these ways.
        yield Fault(depth, f"of {value} alone", _unmeasured(depth, value), SEEING, USED, right=True)
    for what, function, right in (
        ("uint8", lambda value: (value * 255).round().to(torch.uint8), True),
        ("0..255", lambda value: value * 255, True),
        ("channels last", lambda value: value.permute(0, 2, 3, 1), False),
        ("negative", lambda value: value - 2, False),
        ("one channel", lambda value: value[:, :1], False),
        ("rows short", lambda value: value[:1], False),
        ("no numbers", lambda value: ["picture"] * ROWS, False),
        ("of NaN", lambda value: value * math.nan, False),
        ("of infinity", lambda value: value + math.inf, False),
    ):
        yield Fault(image, what, _map(image, function), EVERYONE, BOTH, right)


def _calibration() -> Iterator[Fault]:
    for key in (schema.intrinsics_key("front"), schema.extrinsics_key("wrist")):
        for value in (math.nan, math.inf):
            yield Fault(key, f"{value}", _set(key, (*_LAST, 0), value), SEEING, BOTH)
        for what, function in {
            "zero": lambda value: value * 0,
            "scaled by 30": lambda value: value * 30,
            "one number short": lambda value: value[:, :3],
            "a matrix": lambda value: value[:, None].expand(-1, 3, -1),
            "no numbers": lambda value: ["matrix"] * ROWS,
        }.items():
            yield Fault(key, what, _map(key, function), SEEING, BOTH)


def _absent() -> Iterator[Fault]:
    image, depth = schema.image_key("front"), schema.depth_key("front")
    for key, policies, uses in (
        (schema.STATE, EVERYONE, BOTH),
        (schema.ACTION, SEEING, TRAINED),
        (schema.TASK, SPEAKING, BOTH),
        (image, EVERYONE, BOTH),
        (depth, SEEING, BOTH),
        (schema.intrinsics_key("front"), SEEING, BOTH),
        (schema.extrinsics_key("wrist"), SEEING, BOTH),
    ):
        yield Fault(key, "missing", lambda batch, key=key: batch.pop(key), policies, uses)


def _weights_and_texts() -> Iterator[Fault]:
    key = schema.SAMPLE_WEIGHT
    for value in (math.nan, math.inf, -1.0):
        yield Fault(key, f"{value}", _put(key, torch.tensor([[1.0], [value]])), EVERYONE, TRAINED)
    yield Fault(key, "all 0", _put(key, torch.zeros(ROWS, 1)), EVERYONE, TRAINED)
    wrong = {"null": None, "a number": 7.0, "empty": "", "of 10,000 characters": f"{_RED} " * 500}
    tokens = {"with the stop token": "grasp the <next goal> block", "with an image token": "grasp the <image> block"}
    for what, text in (wrong | tokens).items():
        yield Fault(schema.INSTRUCTION, what, _put(schema.INSTRUCTION, [_RED, text]), SPEAKING, TRAINED)
    for what, text in wrong.items():
        yield Fault(schema.TASK, what, _put(schema.TASK, ["pick up the red block", text]), SPEAKING, BOTH)
    long = _put(schema.PREVIOUS_INSTRUCTION, ["", "grasp it " * 1200])
    yield Fault(schema.PREVIOUS_INSTRUCTION, "of 10,000 characters", long, ("command",), USED)


_NAMES = {schema.depth_key("front"): ("depth",), schema.image_key("front"): ("image", "picture")}
"""Other words by which a sentence may name what came."""


def _set(key: str, where: Any, value: float) -> Callable[[dict[str, Any]], None]:
    def change(batch: dict[str, Any]) -> None:
        batch[key][where] = value

    return change


def _map(key: str, function: Callable[[Any], Any]) -> Callable[[dict[str, Any]], None]:
    def change(batch: dict[str, Any]) -> None:
        batch[key] = function(batch[key])

    return change


def _put(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda batch: batch.update({key: value})


def _scaled(value: torch.Tensor, part: slice, factor: float) -> torch.Tensor:
    changed = value.clone()
    changed[:, part] *= factor
    return changed


def _unmeasured(key: str, value: float) -> Callable[[dict[str, Any]], None]:
    return lambda batch: batch.update({key: torch.full_like(batch[key], value)})
