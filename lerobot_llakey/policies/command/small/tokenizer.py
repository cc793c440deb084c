"""Tokenizer and encoder of the small model: a token for each word and constant sentence, bytes for the rest."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import torch
from torch import Tensor

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.inputs import resize
from lerobot_llakey.policies.command.prompt import STOP, Prompt

PAD, BEGIN, IMAGE, SPACE = "<pad>", "<begin>", "<image>", "<space>"
_SPECIAL = (PAD, BEGIN, IMAGE, STOP, SPACE)
_PIECE = re.compile(r"[^\W_]+|[\W_]")


def grammar_words(grammar: Grammar) -> list[str]:
    """All words in the templates of basic actions and their poses, sorted."""
    texts = [text for template in grammar.templates.values() for text in template.texts]
    plain = [re.sub(r"\{\w+\}", " ", text) for text in texts]
    return known_words([*plain, *grammar.poses])


def known_words(texts: Iterable[str]) -> list[str]:
    """The distinct lower-case words of some texts, sorted."""
    return sorted({piece.lower() for text in texts for piece in _PIECE.findall(text) if piece[0].isalnum()})


class WordTokenizer:
    """Text to token ids and back.

    A known word at the start or after a space is one token, in any letter case. Everything else is spelled in UTF-8
    bytes, so every text has tokens: ``decode(encode(text)) == text`` if its words are single-spaced and its known words
    lower-case.

    Args:
        words: the known words, lower-case.
        sentences: constant sentences; a text that is one of them becomes one token.
    """

    def __init__(self, words: Sequence[str], sentences: Sequence[str] = ()) -> None:
        pieces = [f"<0x{byte:02x}>" for byte in range(256)]
        self._texts: list[str] = [*_SPECIAL, *pieces, *sentences, *words]
        self._first_byte = len(_SPECIAL)
        first_sentence = self._first_byte + len(pieces)
        self._first_word = first_sentence + len(sentences)
        self._sentences = {text: first_sentence + index for index, text in enumerate(sentences)}
        self._words = {word: self._first_word + index for index, word in enumerate(words)}
        self.pad_id, self.begin_id, self.image_id, self.stop_id, self._space_id = range(len(_SPECIAL))

    def __len__(self) -> int:
        return len(self._texts)

    def encode(self, text: str) -> list[int]:
        """Token ids of a text, without begin or stop token."""
        if text in self._sentences:
            return [self._sentences[text]]
        ids: list[int] = []
        for chunk in text.split():
            head, *tail = _PIECE.findall(chunk)
            word = self._words.get(head.lower())
            ids += [self._space_id, *self._spell(head)] if word is None else [word]
            ids += self._spell("".join(tail))
        return ids

    def decode(self, ids: Iterable[int]) -> str:
        """The text of token ids up to the first stop token; begin, image and padding tokens are skipped."""
        spelled = bytearray()
        for token in ids:
            if token == self.stop_id:
                break
            if token == self._space_id:
                spelled += b" "
            elif self._first_byte <= token < self._first_byte + 256:
                spelled.append(token - self._first_byte)
            elif token >= self._first_byte:
                spelled += b" " + self._texts[token].encode()
        return spelled.decode(errors="replace").strip()

    def _spell(self, text: str) -> list[int]:
        return [self._first_byte + byte for byte in text.encode()]


class WordEncoder(Encoder):
    """Encoder of the small model: tokens of :class:`WordTokenizer`, and images scaled to -1..1.

    Args:
        tokenizer: the small tokenizer.
        image_size: pixels a side.
        image_tokens: tokens of an image.
    """

    def __init__(self, tokenizer: WordTokenizer, image_size: int, image_tokens: int) -> None:
        self.tokenizer = tokenizer
        self.image_size = image_size
        self.image_tokens = image_tokens
        self.pad_id, self.stop_id = tokenizer.pad_id, tokenizer.stop_id

    def prompts(self, images: Tensor, prompts: Sequence[Prompt]) -> dict[str, Tensor]:
        rows = [self._ids(prompt) for prompt in prompts]
        longest = max(map(len, rows))
        ids = torch.tensor([[self.pad_id] * (longest - len(row)) + row for row in rows], device=images.device)
        pixels = images.flatten(0, 1)
        if pixels.shape[-2:] != (self.image_size, self.image_size):
            pixels = resize(pixels, (self.image_size, self.image_size))
        return {
            "input_ids": ids,
            "attention_mask": (ids != self.pad_id).long(),
            "pixel_values": pixels * 2 - 1,
        }

    def _ids(self, prompt: Prompt) -> list[int]:
        ids = [self.tokenizer.begin_id, *self.tokenizer.encode(prompt.opening)]
        for description in prompt.descriptions:
            ids += [*self.tokenizer.encode(description), *[self.tokenizer.image_id] * self.image_tokens]
        return ids + [token for piece in prompt.request for token in self.tokenizer.encode(piece)]

    def answer(self, text: str) -> list[int]:
        return [*self.tokenizer.encode(text), self.stop_id]

    def decode(self, ids: Iterable[int]) -> str:
        return self.tokenizer.decode(ids)
