"""What happened to the requests of a chat policy."""

from __future__ import annotations

import threading
from collections import Counter
from dataclasses import dataclass, field


@dataclass
class ChatCounts:
    """Counts since the policy was built; several threads add to them.

    Attributes:
        requests: questions asked.
        answers: answers had.
        retries: further attempts at them.
        unparsable: answers that are not in the grammar of basic actions.
        unanswered: questions without a usable answer after all attempts, by reason.
    """

    requests: int = 0
    answers: int = 0
    retries: int = 0
    unparsable: int = 0
    unanswered: Counter[str] = field(default_factory=Counter)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False, compare=False)

    def asked(self) -> None:
        """Count one question."""
        with self._lock:
            self.requests += 1

    def answered(self, retries: int, parsable: bool) -> int:
        """Count one answer and the further attempts that it took.

        Returns:
            How many unparsable ones there are now if it is one, else 0.
        """
        with self._lock:
            self.answers += 1
            self.retries += retries
            self.unparsable += not parsable
            return 0 if parsable else self.unparsable

    def failed(self, reason: str, retries: int) -> str:
        """Count one question without an answer.

        Returns:
            How many there are now, in words.
        """
        with self._lock:
            self.retries += retries
            self.unanswered[reason] += 1
            return f"{self.unanswered.total()} of {self.requests} requests unanswered so far"
