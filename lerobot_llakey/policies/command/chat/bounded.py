"""HTTP in which a server can take neither more time nor more memory than it was given."""

from __future__ import annotations

import asyncio
import importlib
import threading
from collections.abc import Coroutine
from typing import Any


def bounded_http(openai: Any, seconds: float, most_bytes: int) -> Any:
    """An HTTP client for the ``openai`` package whose every answer is whole within a time and a size.

    Its own time-outs are those between two pieces of an answer: a server that sends a byte now and then meets them for
    ever. Redirections are not followed: pictures go nowhere but to the address that was given.

    Args:
        openai: the package.
        seconds: from connecting to the last byte of the body, at each attempt.
        most_bytes: of a body.

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
    """What came, where an answer is longer than ``most_bytes``."""
    return f"an answer of more than {most_bytes / 1e6:g} MB"


class Background:
    """An event loop in a thread of its own, which ends with the process; it may be used from any thread."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, name="chat", daemon=True).start()

    def result[Result](self, work: Coroutine[Any, Any, Result]) -> Result:
        """What a coroutine returns; it is cancelled if the wait for it is interrupted."""
        future = asyncio.run_coroutine_threadsafe(work, self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise
