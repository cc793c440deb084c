"""A small tokenizer for a small model: one token a word, one token a constant sentence, bytes for everything else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.policies.command.prompt import STOP

PAD, BEGIN, IMAGE, SPACE = "<pad>", "<begin>", "<image>", "<space>"
_SPECIAL = (PAD, BEGIN, IMAGE, STOP, SPACE)
_PIECE = re.compile(r"[^\W_]+|[\W_]")


def grammar_words(grammar: Grammar) -> list[str]:
    """Every word that the templates of basic actions and their poses hold, sorted."""
    texts = [text for template in grammar.templates.values() for text in template.texts]
    plain = [re.sub(r"\{\w+\}", " ", text) for text in texts]
    return known_words([*plain, *grammar.poses])


def known_words(texts: Iterable[str]) -> list[str]:
    """The distinct lower-case words of some texts, sorted: what a vocabulary is built from."""
    return sorted({piece.lower() for text in texts for piece in _PIECE.findall(text) if piece[0].isalnum()})


class WordTokenizer:
    """Text to token ids and back.

    A known word at the start or after a space is one token, whatever its letter case. Anything else is spelled in UTF-8
    bytes, so that no text is unrepresentable: ``decode(encode(text)) == text`` for every text whose words are
    single-spaced and whose known words are lower-case.

    Args:
        words: the known words, lower-case.
        sentences: constant sentences that are one token each when they are encoded as a whole.
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
        """Token ids of a text, without begin or stop tokens."""
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
