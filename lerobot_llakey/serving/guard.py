"""What stands before the page: it answers to its own address alone, and takes no more than a page of text needs.

A page of a stranger, open in the same browser, can send requests to this machine's loopback address, and by DNS
rebinding under a name of its own read the answers. Such requests carry the stranger's Host or Origin.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

MOST_BYTES = 64 * 1024
"""Of a request's body: names, numbers and some sentences."""

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]


class Guard:
    """An ASGI application in front of another one, which sees only requests that a person's own page makes.

    Args:
        app: the page.
        port: at which the page is served.
        names: of this machine, as a browser's address line may say them.
        most_bytes: of a request's body.
    """

    def __init__(
        self,
        app: App,
        port: int,
        names: tuple[str, ...] = ("127.0.0.1", "localhost", "[::1]"),
        most_bytes: int = MOST_BYTES,
    ) -> None:
        self._app, self._most_bytes = app, most_bytes
        self._hosts = {f"{name}:{port}" for name in names} | (set(names) if port == 80 else set())

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it with what is wrong with it."""
        if scope["type"] == "lifespan":
            return await self._app(scope, receive, send)
        if scope["type"] != "http":
            return None  # no websockets
        status, wrong = self._wrong(scope)
        body = await self._body(receive)  # of a refused request, too: closing on unread bytes resets the connection
        if body is None and not wrong:
            status, wrong = 413, f"Expected at most {self._most_bytes} bytes, got more; say it in fewer words."
        if wrong or body is None:
            return await _refuse(send, status, wrong)
        parts: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

        async def replay() -> Message:
            return parts.pop() if parts else await receive()

        return await self._app(scope, replay, send)

    def _wrong(self, scope: Message) -> tuple[int, str]:
        """Status and sentence for a request whose head is refused; an empty sentence for any other."""
        hosts, origins = (_all(scope, name) for name in (b"host", b"origin"))
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            came = ", ".join(hosts)[:80] or "none"
            return 403, f"Expected this page's own address, got {came!r}; open the page itself."
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            came = ", ".join(origins)[:80]
            return 403, f"Expected a request of this page, got one of {came!r}; open the page itself."
        if "upload" in scope["path"]:
            return 403, "Expected words, got a file; the page takes none."
        return 200, ""

    async def _body(self, receive: Receive) -> bytes | None:
        """The whole body; None where it is too long, or the other side has left."""
        body = bytearray()
        while True:
            message = await receive()
            body += message.get("body", b"")
            if len(body) > self._most_bytes or message["type"] == "http.disconnect":
                return None
            if not message.get("more_body"):
                return bytes(body)


def _all(scope: Message, header: bytes) -> list[str]:
    return [value.decode("latin-1").lower() for name, value in scope["headers"] if name.lower() == header]


async def _refuse(send: Send, status: int, sentence: str) -> None:
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": sentence.encode()})
