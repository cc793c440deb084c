"""Questions to an OpenAI-compatible server: which failures are retried, counted, or end the run.

The ``openai`` client sends the requests: it waits longer after each failure, with jitter, or as long as Retry-After
demands (up to two minutes), and keeps keys out of its logs. Limits hold for every server: ``timeout_s`` for each whole
answer, ``LONGEST_WAIT`` between two attempts on average, ``MOST_BYTES``, and ``GIVE_UP_SECONDS`` of silence.
"""

from __future__ import annotations

import asyncio
import logging
import os
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from lerobot_llakey.errors import LlakeyError, said
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.chat.messages import Message, first_instruction
from lerobot_llakey.policies.command.chat.settings import POLICY_OPTIONS, UNNAMED, ChatSettings, repeats
from lerobot_llakey.policies.command.chat.transport import Background, bounded_http, completion_text, too_long

log = logging.getLogger(__name__)

MOST_BYTES = 1_000_000
"""Longest answer: an instruction has some dozens, the thoughts of a model some thousands."""
LONGEST_WAIT = 30.0
"""Seconds between two attempts, on average, whatever Retry-After says."""
GIVE_UP_SECONDS = 600.0
"""The run ends after so long without any answer; checked between questions, not within one."""
NO_KEY = "none"
"""Sent if no key is set: the client needs one, a local server ignores it."""

_RETRIED = {408, 409, 429}
_REASONS = {
    401: "the API key was not accepted",
    403: "the API key may not use this model",
    404: "there is no such address or model",
}


@dataclass
class ChatCounts:
    """What happened to the requests since the policy was built.

    Attributes:
        requests: questions asked.
        answers: answers received.
        retries: further attempts.
        unparsable: answers outside the grammar.
        unanswered: questions without a usable answer after all attempts, by reason.
    """

    requests: int = 0
    answers: int = 0
    retries: int = 0
    unparsable: int = 0
    unanswered: Counter[str] = field(default_factory=Counter)


class ChatClient:
    """Sends questions to one model of one server.

    Args:
        base_url: address of the API, such as http://127.0.0.1:8000/v1; None is OpenAI's own.
        model: the model's name there.
        settings: see :class:`ChatSettings`.
        max_tokens: longest answer.
        grammar: of the answers.
        options: how errors begin the names of the options ``base_url`` and ``model``.

    Attributes:
        counts: what happened so far; written by the event loop's thread alone.

    Raises:
        LlakeyError: if the ``openai`` package is not installed.
    """

    def __init__(
        self,
        base_url: str | None,
        model: str,
        settings: ChatSettings,
        max_tokens: int,
        grammar: Grammar = BASIC_GRAMMAR,
        *,
        options: str = POLICY_OPTIONS,
    ) -> None:
        try:
            import openai
        except ImportError:
            raise LlakeyError(
                "Expected the package openai for backend=chat, got an environment without it; "
                "pip install 'lerobot_policy_llakey[chat]'."
            ) from None
        self.model = model
        self.settings = settings
        self.grammar = grammar
        self.counts = ChatCounts()
        self._openai, self._named = openai, options
        self._key = os.environ.get(settings.api_key_env) or NO_KEY
        self._client: Any = openai.AsyncOpenAI(
            api_key=self._key,
            base_url=base_url or None,
            max_retries=settings.max_attempts - 1,
            timeout=settings.timeout_s,
            default_headers={"Accept-Encoding": "identity"},  # a short answer may unpack into a long one
            http_client=bounded_http(openai, settings.timeout_s, MOST_BYTES),
        )
        self._background = Background()
        self._longest = settings.max_attempts * settings.timeout_s + (settings.max_attempts - 1) * LONGEST_WAIT
        self._unnamed = base_url == UNNAMED
        self._options: dict[str, Any] = {"model": model, settings.max_tokens_field: max_tokens}
        if settings.temperature is not None:
            self._options["temperature"] = settings.temperature
        self._reached = False
        self._silent_since: float | None = None
        for name in ("httpx", "httpx2"):  # a line for each request would drown the run's own lines
            if logging.getLogger(name).level == logging.NOTSET:
                logging.getLogger(name).setLevel(logging.WARNING)

    @property
    def address(self) -> str:
        """Where requests go."""
        return str(self._client.base_url)

    def ask_all(self, conversations: Sequence[Sequence[Message]]) -> list[str]:
        """Ask for one instruction a conversation, ``max_parallel`` at once; thread-safe.

        Each question takes at most ``max_attempts`` x ``timeout_s``, and ``LONGEST_WAIT`` for each wait in between.

        Returns:
            One line each, which need not be in the grammar; "" if all attempts failed, which is counted and logged.

        Raises:
            LlakeyError: if a retry would not help: the server refuses the request; it has never answered and cannot be
                reached or is no chat server; or it has not answered for ``GIVE_UP_SECONDS``.
        """
        if self._unnamed:
            raise LlakeyError(
                f"Expected the user to name the server of the chat model {self.model!r}, got a checkpoint that may "
                "not; give --policy.base_url=... (--policy.command.base_url=... of a hierarchy), such as "
                "https://api.openai.com/v1."
            )
        return self._background.result(self._ask_all(conversations))

    async def _ask_all(self, conversations: Sequence[Sequence[Message]]) -> list[str]:
        places = asyncio.Semaphore(self.settings.max_parallel)

        async def ask(messages: Sequence[Message]) -> str:
            async with places:
                return await self._ask(messages)

        try:
            async with asyncio.TaskGroup() as group:
                tasks = [group.create_task(ask(messages)) for messages in conversations]
        except ExceptionGroup as errors:  # the others are cancelled then
            raise errors.exceptions[0] from None
        return [task.result() for task in tasks]

    async def _ask(self, messages: Sequence[Message]) -> str:
        self.counts.requests += 1
        started = time.monotonic()
        try:
            async with asyncio.timeout(self._longest):
                completions = self._client.chat.completions.with_raw_response
                answer = await completions.create(messages=list(messages), **self._options)
        except self._openai.APIStatusError as error:
            status = error.status_code
            if status not in _RETRIED and status < 500:
                raise self._refused(error) from None
            return self._unanswered(f"status {status}", error, started)
        except (self._openai.APITimeoutError, TimeoutError) as error:
            return self._unanswered("time-out", error, started)
        except self._openai.APIConnectionError as error:
            if not self._reached:
                raise self._wrong_address("no connection") from None
            return self._unanswered("no connection", error, started)
        except self._openai.OpenAIError as error:
            if str(error) != too_long(MOST_BYTES):
                raise
            return self._nonsense(too_long(MOST_BYTES), started)
        text = completion_text(answer.http_response.content)
        if text is None:
            return self._nonsense("an answer that is no chat completion", started)
        if self._is_secret(text):
            return self._nonsense("an answer that repeats the API key", started)
        self._reached, self._silent_since = True, None
        instruction = first_instruction(text, self.grammar)
        self.counts.answers += 1
        self.counts.retries += answer.retries_taken
        if not self.grammar.is_parsable(instruction):
            self.counts.unparsable += 1
            if self.counts.unparsable.bit_count() == 1:  # at the first, second, fourth, eighth...
                log.warning(
                    "%s answered %r, which is no basic action: %d of %d answers so far.",
                    *(self.model, instruction[:80], self.counts.unparsable, self.counts.answers),
                )
        return instruction

    def _nonsense(self, what: str, started: float) -> str:
        if not self._reached:
            raise self._wrong_address(what)
        return self._unanswered("nonsense", None, started)

    def _unanswered(self, reason: str, error: Any, started: float) -> str:
        # The client numbers its attempts in this header.
        request = getattr(error, "request", None)
        retries = 0 if request is None else int(request.headers.get("x-stainless-retry-count", 0))
        self.counts.retries += retries
        self.counts.unanswered[reason] += 1
        summary = f"{self.counts.unanswered.total()} of {self.counts.requests} requests unanswered so far"
        log.warning("No answer from %s (%s, %d attempts); %s.", self.address, reason, retries + 1, summary)
        self._silent_since = started if self._silent_since is None else self._silent_since
        silent = time.monotonic() - self._silent_since
        if silent >= GIVE_UP_SECONDS:
            raise LlakeyError(
                f"Expected answers of the chat server at {self.address}, got none for {silent:.0f} s ({reason}; "
                f"{summary}); start again when it answers."
            )
        return ""

    def _is_secret(self, text: str) -> bool:
        return self._key != NO_KEY and repeats(text, self._key)

    def _refused(self, error: Any) -> LlakeyError:
        """The error for a request that the server rejects, however often it is sent."""
        status = error.status_code
        words = said(error.message, 300)
        if self._is_secret(words):
            words = "its words repeat the API key and are left out"
        elsewhere = 300 <= status < 400
        reason = "it sends elsewhere" if elsewhere else _REASONS.get(status, words)
        advice = {
            401: f"set the environment variable {self.settings.api_key_env} to a valid key",
            403: f"set the environment variable {self.settings.api_key_env} to a key that may",
            404: f"check {self._named}base_url and {self._named}model={self.model}",
        }.get(status, "check the model and the chat settings against what the server takes")
        advice = f"check {self._named}base_url" if elsewhere else advice
        return LlakeyError(
            f"Expected an answer of the chat server at {self.address}, got status {status}: {reason}; {advice}."
        )

    def _wrong_address(self, what: str) -> LlakeyError:
        advice = f"start it or correct {self._named}base_url (most end in /v1)"
        return LlakeyError(f"Expected a chat-completions server at {self.address}, got {what}; {advice}.")
