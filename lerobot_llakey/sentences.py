"""Free text: any sentence, within bounds."""

from __future__ import annotations

import re

from lerobot_llakey.errors import LlakeyError

LONGEST_SENTENCE = 1000
"""Characters of a text that a policy reads. A language model's time and memory grow faster than its prompt."""
MARKER = re.compile(r"<[^<>\s][^<>]*>|\[/?[A-Z][A-Z_]+\]")
"""What language models take for the end of an answer, a turn or an image: "<next goal>", "<image>", "[INST]"."""
SENTENCE = "sentence"
"""The template of every free text, and its only slot."""
_SHOWN = 200


def read_sentence(text: str) -> str:
    """A sentence with single spaces.

    Raises:
        LlakeyError: if it is empty, too long, or holds a language model's own marker.
    """
    plain = " ".join(text.split())
    if not plain or len(plain) > LONGEST_SENTENCE or MARKER.search(plain):
        raise LlakeyError(
            f"Expected a sentence of at most {LONGEST_SENTENCE} characters in plain words, got {shortened(text)}; "
            "reword it."
        )
    return plain


def shortened(text: str) -> str:
    """A text as an error quotes it: the beginning of a long one, with its length."""
    return repr(text) if len(text) <= _SHOWN else f"{text[:_SHOWN]!r}... ({len(text)} characters)"
