"""Texts survive being arrays."""

import pytest

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sim.text_codes import decode_text, encode_text


def test_text_survives_encoding() -> None:
    text = "slide the red block to the orange target"
    assert decode_text(encode_text(text)) == text
    with pytest.raises(ValueError, match="Expected at most"):
        encode_text("x" * (schema.TEXT_LENGTH + 1))


@pytest.mark.parametrize("code", [float("nan"), float("inf"), -1.0, 2.0**21, 97.5])
def test_what_is_no_code_point_is_refused(code: float) -> None:
    codes = encode_text("grasp")
    codes[2] = code
    with pytest.raises(LlakeyError, match=r"code points from 0 to 1114111, got .* at place 2"):
        decode_text(codes)
