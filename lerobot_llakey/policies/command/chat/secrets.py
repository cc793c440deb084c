"""Whether a text repeats a secret, in whole or in part, plainly or disguised."""

from __future__ import annotations

import base64
import re

PIECE = 8
"""Characters of a secret that tell something of it."""
_NO_SIGN = re.compile(r"[^0-9a-z]")


def repeats(text: str, secret: str) -> bool:
    """Whether any ``PIECE`` characters of a secret stand in a text: forwards or backwards, as base64 or in hex.

    Case, and signs that are neither letters nor digits, do not count. A secret that is shorter is looked for as a
    whole; an empty one is in no text.
    """
    heard = _NO_SIGN.sub("", text.lower())
    return any(piece in heard for form in _forms(secret) for piece in _pieces(form))


def _forms(secret: str) -> list[str]:
    raw = secret.encode()
    # base64 reads three bytes at a time: the letters depend on how many stand before the secret.
    shifted = [base64.b64encode(bytes(before) + raw)[before + 1 if before else 0 :].decode() for before in range(3)]
    plain = [secret, raw.hex(), *shifted]
    return [form for one in plain if (form := _NO_SIGN.sub("", one.lower()))] + [
        form for one in plain if (form := _NO_SIGN.sub("", one[::-1].lower()))
    ]


def _pieces(form: str) -> list[str]:
    size = min(PIECE, len(form))
    return [form[start : start + size] for start in range(len(form) - size + 1)]
