"""What gets past the guard: a fake application notes it."""

import asyncio
from typing import Any

import pytest

from lerobot_llakey.serving.guard import Guard

HOME = "127.0.0.1:7860"


def _ask(
    host: str | None = HOME, method: str = "POST", path: str = "/", body: tuple[bytes, ...] = (b"{}",), **headers: str
) -> tuple[int, list[bytes]]:
    """Status of the answer, and the bodies that the application behind the guard was given."""
    given: list[bytes] = []
    sent: list[Any] = []
    parts = [{"type": "http.request", "body": part, "more_body": True} for part in body]
    parts.append({"type": "http.request", "body": b"", "more_body": False})

    async def app(scope: Any, receive: Any, send: Any) -> None:
        given.append((await receive())["body"])
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive() -> Any:
        return parts.pop(0)

    async def send(message: Any) -> None:
        sent.append(message)

    all_headers = ({} if host is None else {"host": host}) | headers
    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "headers": [(name.encode(), value.encode()) for name, value in all_headers.items()],
    }
    asyncio.run(Guard(app, 7860)(scope, receive, send))
    return sent[0]["status"], given


@pytest.mark.parametrize("host", [HOME, "localhost:7860", "[::1]:7860", "LOCALHOST:7860"])
def test_its_own_addresses_pass(host: str) -> None:
    assert _ask(host) == (200, [b"{}"])
    assert _ask(host, origin=f"http://{host}") == (200, [b"{}"])


@pytest.mark.parametrize(
    "host",
    ["evil.com", "evil.com:7860", "127.0.0.1", "127.0.0.1:80", "127.0.0.1.evil.com:7860", "0.0.0.0:7860", None],
)
@pytest.mark.parametrize("method", ["GET", "POST", "OPTIONS"])
def test_any_other_host_is_refused(host: str | None, method: str) -> None:
    assert _ask(host, method) == (403, [])


@pytest.mark.parametrize(
    "origin",
    ["http://evil.com:7860", "null", "https://127.0.0.1:7860", "http://127.0.0.1:3000", "http://localhost:7860"],
)
def test_a_request_of_another_page_is_refused(origin: str) -> None:
    assert _ask(origin=origin) == (403, [])


@pytest.mark.parametrize("path", ["/gradio_api/upload", "/upload", "/gradio_api/upload_progress"])
def test_files_are_refused(path: str) -> None:
    assert _ask(path=path) == (403, [])


def test_a_long_body_is_refused_unread_and_a_short_one_arrives_whole() -> None:
    assert _ask(body=(b"a" * 1000,) * 60) == (200, [b"a" * 60_000])
    assert _ask(body=(b"a" * 1000,) * 1000) == (413, [])


def test_websockets_are_left_alone() -> None:
    async def never(*_: Any) -> None:
        pytest.fail("the application was reached")

    asyncio.run(Guard(never, 7860)({"type": "websocket", "headers": []}, never, never))
