"""HTTP to a chat server, with a limit on the time and the size of each answer."""

from __future__ import annotations

import asyncio
import importlib
import json
import threading
from collections.abc import Coroutine
from typing import Any


def bounded_http(openai: Any, seconds: float, most_bytes: int) -> Any:
    """An HTTP client for the ``openai`` package that limits the time and the size of each whole answer.

    The package's own time-outs apply between two pieces of an answer, so a server that sends a byte now and then never
    exceeds them. Redirections are not followed: images are sent to the given address alone.

    Args:
        openai: the package.
        seconds: limit of each attempt, from connecting to the last byte of the body.
        most_bytes: limit of a body.

    Returns:
        A client whose ``send`` raises the HTTP library's ``ReadTimeout``, after which ``openai`` tries again, or
        ``openai.OpenAIError`` with the words of :func:`too_long`, after which it does not.
    """

    class BoundedClient(openai.DefaultAsyncHttpxClient):
        async def send(self, request: Any, *, stream: bool = False, **how: Any) -> Any:
            http = importlib.import_module(type(request).__module__.partition(".")[0])  # httpx, or its successor
            try:
                async with asyncio.timeout(seconds):
                    answer = await super().send(request, stream=True, **how)
                    try:
                        body = bytearray()
                        async for piece in answer.aiter_bytes():
                            body += piece
                            if len(body) > most_bytes:
                                raise openai.OpenAIError(too_long(most_bytes))
                    finally:
                        await answer.aclose()
            except TimeoutError:
                raise http.ReadTimeout(f"no whole answer within {seconds:g} s", request=request) from None
            headers = [(name, value) for name, value in answer.headers.items() if name.lower() != "content-encoding"]
            return http.Response(answer.status_code, headers=headers, content=bytes(body), request=request)

    return BoundedClient(timeout=seconds, follow_redirects=False)


def too_long(most_bytes: int) -> str:
    """Names an answer longer than ``most_bytes`` in an error."""
    return f"an answer of more than {most_bytes / 1e6:g} MB"


class Background:
    """An event loop in a daemon thread; any thread may use it."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, name="chat", daemon=True).start()

    def result[Result](self, work: Coroutine[Any, Any, Result]) -> Result:
        """Run a coroutine and return its result; an interrupt cancels it."""
        future = asyncio.run_coroutine_threadsafe(work, self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise


def completion_text(body: bytes) -> str | None:
    """The text of a chat completion; None if the body is something else."""
    try:
        content = json.loads(body)["choices"][0]["message"]["content"]
    except (ValueError, LookupError, TypeError, RecursionError):
        return None
    if isinstance(content, list):  # some servers answer in parts
        texts = [part.get("text") for part in content if isinstance(part, dict)]
        content = "".join(text for text in texts if isinstance(text, str))
    # Null comes from a model that only thought, or declined: an empty answer.
    return content if isinstance(content, str) else "" if content is None else None
