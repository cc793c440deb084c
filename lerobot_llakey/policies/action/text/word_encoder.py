"""How texts become word vectors: by a small encoder that is trained along and needs no vocabulary file, by default."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from functools import lru_cache
from hashlib import blake2b

import torch
from torch import Tensor, nn

from lerobot_llakey.errors import LlakeyError

_UNSPACED = ("CJK", "HIRAGANA", "KATAKANA", "THAI", "LAO", "KHMER", "MYANMAR")
"""Scripts written without spaces between words: each of their letters is taken for a word."""


@lru_cache(maxsize=4096)
def _hash(word: str, buckets: int) -> tuple[int, int]:
    digest = blake2b(word.encode(), digest_size=8).digest()
    return 1 + int.from_bytes(digest[:4], "big") % buckets, 1 + int.from_bytes(digest[4:], "big") % buckets


def words_of(text: str) -> list[str]:
    """The words of a text in lower case: letters and digits of any script, and each vertical bar.

    Punctuation parts words and is dropped. Text in a script without spaces falls into its letters.
    """
    return [word for run in _runs(unicodedata.normalize("NFC", text.lower())) for word in run]


def _runs(text: str) -> Iterator[list[str]]:
    run = ""
    for character in text:
        kind = unicodedata.category(character)[0]
        alone = _stands_alone(character) or bool(run and _stands_alone(run[0]))
        # Vowel signs and accents (M) belong to the letter before them.
        if (kind == "M" and run) or (kind in "LN" and not alone):
            run += character
            continue
        yield [run] if run else []
        run = character if kind in "LN" else ""
        if character == "|":
            yield ["|"]
    yield [run] if run else []


@lru_cache(maxsize=4096)
def _stands_alone(character: str) -> bool:
    return character > "\u0dff" and unicodedata.name(character, "").startswith(_UNSPACED)


def hash_words(texts: Sequence[str], length: int, buckets: int) -> Tensor:
    """Two independent hashes of each word.

    Args:
        texts: B texts; case and punctuation are ignored.
        length: of the longest text, in words.
        buckets: hashes lie in 1..buckets; 0 marks padding.

    Returns:
        (B, length, 2) int64, the same on every machine. Two words are confused only if both hashes agree.

    Raises:
        LlakeyError: naming the row if a text has more words, or is not empty and has none.
    """
    hashes = torch.zeros(len(texts), length, 2, dtype=torch.int64)
    for row, text in enumerate(texts):
        words = words_of(text)
        if len(words) > length:
            raise LlakeyError(
                f"Expected at most {length} words (policy.text_length), got {len(words)} in batch row {row} "
                f"({' '.join(words[:6])} ...); shorten the text, or train with a larger text_length."
            )
        if not words and text.strip():
            raise LlakeyError(
                f"Expected letters or digits in a text, got {text!r} in batch row {row}; give the policy words."
            )
        for column, word in enumerate(words):
            hashes[row, column] = torch.tensor(_hash(word, buckets))
    return hashes


class TextEncoder(nn.Module):
    """Words to vectors: hashed embeddings, positions and a short transformer."""

    def __init__(self, width: int, layers: int, buckets: int, length: int) -> None:
        super().__init__()
        self.buckets, self.length, self.width = buckets, length, width
        self.first = nn.Embedding(buckets + 1, width)
        self.second = nn.Embedding(buckets + 1, width)
        self.positions = nn.Parameter(torch.randn(length, width) * 0.3)
        layer = nn.TransformerEncoderLayer(
            width, 4, 2 * width, dropout=0.0, activation="gelu", batch_first=True, norm_first=True
        )
        self.layers = nn.TransformerEncoder(layer, layers, enable_nested_tensor=False)
        self.norm = nn.LayerNorm(width)

    def forward(self, texts: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Encode B texts.

        Returns:
            Word vectors (B, T, width), and (B, T) bool that is true at padding. An empty text keeps one blank word.
        """
        words = hash_words(texts, self.length, self.buckets)
        longest = max(1, int((words[..., 0] > 0).sum(dim=1).max()))
        words = words[:, :longest].to(self.positions.device)
        padding = words[..., 0] == 0
        padding[:, 0] = False
        embedded = self.first(words[..., 0]) + self.second(words[..., 1])
        encoded = self.layers(embedded + self.positions[:longest], src_key_padding_mask=padding)
        return self.norm(embedded + encoded), padding


class QueryPool(nn.Module):
    """Learned queries that each pick words: (B, T, width) -> (B, queries, out)."""

    def __init__(self, width: int, queries: int, out: int) -> None:
        super().__init__()
        self.scores = nn.Linear(width, queries)
        self.values = nn.Linear(width, out)

    def forward(self, words: Tensor, padding: Tensor) -> Tensor:
        scores = self.scores(words).masked_fill(padding[..., None], float("-inf"))
        return scores.softmax(dim=1).transpose(1, 2) @ self.values(words)


class TextRoles(nn.Module):
    """Puts the words of several texts side by side, each marked with what its text is: the task or the instruction."""

    def __init__(self, texts: int, width: int) -> None:
        super().__init__()
        self.marks = nn.Parameter(torch.randn(texts, width) * 0.3)

    def forward(self, encoded: Sequence[tuple[Tensor, Tensor]]) -> tuple[Tensor, Tensor]:
        """Word vectors (B, T, width) and padding (B, T) of each text, to those of all (B, sum of T, ...)."""
        words = [words + mark for (words, _), mark in zip(encoded, self.marks, strict=True)]
        return torch.cat(words, dim=1), torch.cat([padding for _, padding in encoded], dim=1)
