"""One question to an OpenAI-compatible server: what is tried again, what is given up, and what stops the run.

The ``openai`` client carries the requests: it waits longer after each failure, with jitter, or as long as Retry-After
says (up to two minutes), bounds attempts and waiting, and keeps keys out of its logs.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence
from typing import Any

from lerobot_llakey import instructions
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat.answers import first_instruction
from lerobot_llakey.policies.command.chat.counts import ChatCounts
from lerobot_llakey.policies.command.chat.messages import Message
from lerobot_llakey.policies.command.chat.settings import ChatSettings

log = logging.getLogger(__name__)

CONNECT_SECONDS = 10.0
NO_KEY = "none"
"""Sent as the key where none is set: the client wants one, a server of one's own does not look at it."""

_RETRIED = {408, 409, 429}
_REASONS = {
    401: "the API key was not accepted",
    403: "the API key may not use this model",
    404: "there is no such address or model",
}


class ChatClient:
    """Asks one model of one server.

    Args:
        base_url: address of the API, such as http://127.0.0.1:8000/v1; None is that of OpenAI.
        model: the model's name there.
        settings: see :class:`ChatSettings`.
        max_tokens: longest answer.

    Attributes:
        counts: what happened so far.

    Raises:
        LlakeyError: if the ``openai`` package is not installed.
    """

    def __init__(self, base_url: str | None, model: str, settings: ChatSettings, max_tokens: int) -> None:
        try:
            import openai
        except ImportError:
            raise LlakeyError(
                "Expected the package openai for backend=chat, got an environment without it; "
                "pip install 'lerobot_policy_llakey[chat]'."
            ) from None
        self.model = model
        self.settings = settings
        self.counts = ChatCounts()
        self._openai: Any = openai
        self._key = os.environ.get(settings.api_key_env) or NO_KEY
        self._client: Any = openai.OpenAI(
            api_key=self._key,
            base_url=base_url,
            max_retries=settings.max_attempts - 1,
            timeout=openai.Timeout(settings.timeout_s, connect=min(CONNECT_SECONDS, settings.timeout_s)),
        )
        self._options: dict[str, Any] = {"model": model, settings.max_tokens_field: max_tokens}
        if settings.temperature is not None:
            self._options["temperature"] = settings.temperature
        self._reached = False
        for name in ("httpx", "httpx2"):  # a line for each request would drown the run's own lines
            if logging.getLogger(name).level == logging.NOTSET:
                logging.getLogger(name).setLevel(logging.WARNING)

    @property
    def address(self) -> str:
        """Where requests go."""
        return str(self._client.base_url)

    def ask(self, messages: Sequence[Message]) -> str:
        """The instruction that the model answers with; thread-safe.

        Returns:
            One line, which need not be in the grammar; "" where there was no usable answer after all attempts, which is
            counted and warned about.

        Raises:
            LlakeyError: if asking again would not help: the server refuses the request, or it has never given an
                answer and cannot be reached or speaks something else.
        """
        self.counts.asked()
        try:
            answer = self._client.chat.completions.with_raw_response.create(messages=list(messages), **self._options)
        except self._openai.APIStatusError as error:
            status = error.status_code
            if status not in _RETRIED and status < 500:
                raise self._refused(error) from None
            return self._unanswered(f"status {status}", error)
        except self._openai.APITimeoutError as error:
            return self._unanswered("time-out", error)
        except self._openai.APIConnectionError as error:
            if not self._reached:
                raise self._wrong_address("no connection") from None
            return self._unanswered("no connection", error)
        text = _content(answer.http_response)
        if text is None:
            if not self._reached:
                raise self._wrong_address("an answer that is no chat completion")
            return self._unanswered("nonsense", None)
        self._reached = True
        instruction = first_instruction(text)
        unparsable = self.counts.answered(answer.retries_taken, instructions.is_parsable(instruction))
        if unparsable.bit_count() == 1:  # at the first, second, fourth, eighth...
            log.warning(
                "%s answered %r, which is no basic action: %d of %d answers so far.",
                *(self.model, text[:80], unparsable, self.counts.answers),
            )
        return instruction

    def _unanswered(self, reason: str, error: Any) -> str:
        # The client numbers its attempts in this header.
        retries = 0 if error is None else int(error.request.headers.get("x-stainless-retry-count", 0))
        summary = self.counts.failed(reason, retries)
        log.warning("No answer from %s (%s, %d attempts); %s.", self.address, reason, retries + 1, summary)
        return ""

    def _refused(self, error: Any) -> LlakeyError:
        """The error for a request that the server will not take, however often it is sent."""
        status = error.status_code
        # A server may repeat the key in its words: those about keys are left out, and the key in any others.
        said = " ".join(str(error.message).replace(self._key, "***").split())[:300]
        reason = _REASONS.get(status, said)
        advice = {
            401: f"set the environment variable {self.settings.api_key_env} to a valid key",
            403: f"set the environment variable {self.settings.api_key_env} to a key that may",
            404: f"check --policy.base_url and --policy.model={self.model}",
        }.get(status, "check the model and the chat settings against what the server takes")
        return LlakeyError(
            f"Expected an answer of the chat server at {self.address}, got status {status}: {reason}; {advice}."
        )

    def _wrong_address(self, what: str) -> LlakeyError:
        return LlakeyError(
            f"Expected a chat-completions server at {self.address}, got {what}; start it or correct --policy.base_url "
            "(most end in /v1)."
        )


def _content(response: Any) -> str | None:
    """The text of a chat completion; None where the response is something else."""
    try:
        content = response.json()["choices"][0]["message"]["content"]
    except (ValueError, LookupError, TypeError):
        return None
    if isinstance(content, list):  # some servers answer in parts
        content = "".join(part.get("text") or "" for part in content if isinstance(part, dict))
    # A model that only thought, or declined, has answered: with nothing.
    return content if isinstance(content, str) else "" if content is None else None
