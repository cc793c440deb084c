"""Texts as arrays, the only kind of value that Gymnasium and LeRobot pass from environments to their processors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from lerobot.configs import PipelineFeatureType, PolicyFeature
from lerobot.processor import ObservationProcessorStep, ProcessorStepRegistry

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError

_CODE_POINTS = 0x110000
"""How many code points there may be."""


def encode_text(text: str) -> np.ndarray:
    """Text as float32 code points of shape (TEXT_LENGTH,), zero-padded.

    Raises:
        LlakeyError: if the text is longer than TEXT_LENGTH.
    """
    if len(text) > schema.TEXT_LENGTH:
        raise LlakeyError(f"Expected at most {schema.TEXT_LENGTH} characters, got {len(text)}: {text!r}; shorten it.")
    codes = np.zeros(schema.TEXT_LENGTH, dtype=np.float32)
    codes[: len(text)] = [ord(character) for character in text]
    return codes


def decode_text(codes: Any) -> str:
    """Inverse of :func:`encode_text` for one array or tensor of shape (TEXT_LENGTH,).

    Raises:
        LlakeyError: if a number is no code point.
    """
    numbers = np.asarray(codes, dtype=np.float64).reshape(-1)
    wrong = ~((numbers >= 0) & (numbers < _CODE_POINTS) & (numbers == np.floor(numbers)))  # NaN is wrong
    if wrong.any():
        raise LlakeyError(
            f"Expected a text as code points from 0 to {_CODE_POINTS - 1}, got {numbers[wrong][0]:g} at place "
            f"{int(wrong.argmax())}; make it with encode_text."
        )
    return "".join(chr(int(number)) for number in numbers if number > 0)


@dataclass
@ProcessorStepRegistry.register(name="llakey_oracle_text")
class OracleTextStep(ObservationProcessorStep):
    """Turns the expert's instructions, code points (B, TEXT_LENGTH), into a list of texts, where there are any."""

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        if schema.ORACLE_INSTRUCTION not in observation:
            return observation
        texts = [decode_text(codes) for codes in observation[schema.ORACLE_INSTRUCTION]]
        return observation | {schema.ORACLE_INSTRUCTION: texts}

    def transform_features(
        self, features: dict[PipelineFeatureType, dict[str, PolicyFeature]]
    ) -> dict[PipelineFeatureType, dict[str, PolicyFeature]]:
        return features
