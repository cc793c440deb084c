"""Chat servers that drip, flood, never end, refuse for ever or speak something else."""

from __future__ import annotations

import contextlib
import gzip
import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import torch

from fuzz.case import Case

Talk = Callable[[socket.socket], None]
"""What a server does with a connection once it has read the request."""

_HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n"
_PATIENCE = 60.0


def _completion(content: object) -> bytes:
    return json.dumps(
        {"object": "chat.completion", "choices": [{"index": 0, "message": {"content": content}}]}
    ).encode()


def _whole(body: bytes, head: bytes = _HEAD) -> Talk:
    return lambda talk: talk.sendall(head + b"Content-Length: %d\r\n\r\n" % len(body) + body)


def _status(code: int, headers: bytes = b"", body: bytes = b"{}") -> Talk:
    return _whole(body, b"HTTP/1.1 %d Status\r\nContent-Type: application/json\r\n" % code + headers)


def _drip(before: bytes, piece: bytes) -> Talk:
    def talk(connection: socket.socket) -> None:
        connection.sendall(before)
        end = time.monotonic() + _PATIENCE
        while time.monotonic() < end:
            connection.sendall(piece)
            time.sleep(0.2)

    return talk


def _flood(before: bytes, piece: bytes) -> Talk:
    def talk(connection: socket.socket) -> None:
        connection.sendall(before)
        for _ in range(4_000):
            connection.sendall(piece * (2**20 // len(piece)))

    return talk


def _wait(connection: socket.socket) -> None:
    time.sleep(_PATIENCE)


def _serve(listener: socket.socket, talk: Talk) -> None:
    def one(connection: socket.socket) -> None:
        with contextlib.suppress(OSError), connection:
            connection.recv(2**20)
            talk(connection)

    while True:
        connection, _ = listener.accept()
        threading.Thread(target=one, args=(connection,), daemon=True).start()


def _ask(talk: Talk, _: Path) -> str | None:
    """A run that never had an answer ends with a sentence; an answer of nothing is counted and said."""
    from lerobot_llakey import schema
    from lerobot_llakey.policies.command.chat import client
    from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
    from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy

    client.LONGEST_WAIT = 1.0  # the bound is the same; half a minute of patience for each server is not
    listener = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=_serve, args=(listener, talk), daemon=True).start()
    config = LlakeyCommandConfig(
        device="cpu",
        image_size=32,
        backend="chat",
        model="tiny",
        base_url=f"http://127.0.0.1:{listener.getsockname()[1]}/v1",
        instructions=["grasp the red block"],
        cameras=["front"],
    )
    config.chat.timeout_s, config.chat.max_attempts = 1.0, 2
    policy = LlakeyCommandPolicy(config)
    batch = {key: torch.rand(1, 3, 32, 32) for key in config.image_keys} | {schema.TASK: ["pick up the red block"]}
    answer = policy.answer(batch)[0]
    return "warned" if policy.unparsable == 1 and len(answer.text) < 1000 else None


def cases(folder: Path, rng: np.random.Generator) -> Iterator[Case]:
    """Every way of not answering a question."""
    zipped = gzip.compress(b"[" * 10**8)
    talks: dict[str, Talk] = {
        "accepts and says nothing": _wait,
        "closes at once": lambda connection: None,
        "drips its headers": _drip(b"HTTP/1.1 200 OK\r\n", b"X-A: b\r\n"),
        "drips one header": _drip(b"HTTP/1.1 200 OK\r\nX-A: ", b"a"),
        "drips its body": _drip(_HEAD + b"Content-Length: 100000\r\n\r\n", b" "),
        "drips chunks": _drip(_HEAD + b"Transfer-Encoding: chunked\r\n\r\n", b"1\r\n \r\n"),
        "drips a body without length": _drip(_HEAD + b"Connection: close\r\n\r\n", b" "),
        "never ends its body": _flood(_HEAD + b"Connection: close\r\n\r\n", b" "),
        "never ends its chunks": _flood(
            _HEAD + b"Transfer-Encoding: chunked\r\n\r\n", b"100\r\n" + b" " * 256 + b"\r\n"
        ),
        "never ends its headers": _flood(b"HTTP/1.1 200 OK\r\n", b"X-A: bbbbbbb\r\n"),
        "promises more than it sends": _whole(b"{", _HEAD + b"Content-Length: 900\r\n"),
        "packs a bomb": _whole(zipped, _HEAD + b"Content-Encoding: gzip\r\n"),
        "packs what is no archive": _whole(b"{}", _HEAD + b"Content-Encoding: gzip\r\n"),
        "speaks no HTTP": lambda connection: connection.sendall(b"SSH-2.0-OpenSSH\r\n"),
        "leads in a circle": _status(307, b"Location: /v1/chat/completions\r\n"),
        "leads to a file": _status(302, b"Location: file:///etc/passwd\r\n"),
        "nested brackets": _whole(b"[" * 200_000),
        "nested content": _whole(_completion("x").replace(b'"x"', b"[" * 100_000 + b"]" * 100_000)),
        "an answer of a megabyte": _whole(_completion("1. " * 400_000)),
    }
    for code in (400, 401, 403, 404, 408, 409, 418, 429, 500, 502, 503, 999):
        talks[f"status {code} for ever"] = _status(code)
        talks[f"status {code} with a late retry"] = _status(code, b"Retry-After: 119\r\n")
    for name, content in {
        "number": 7, "parts of numbers": [{"type": "text", "text": 7}], "parts of null": [{"text": None}, None],
        "map": {"a": 1}, "true": True, "empty": "", "control characters": "\x1b[2J\x00",
        "prose": "I cannot help. " * 50,
    }.items():  # fmt: skip
        talks[f"content is {name}"] = _whole(_completion(content))
    for name, body in {
        "nothing": b"", "text": b"welcome", "no JSON": b'{"choices": [', "not UTF-8": b'{"choices": "\xff\xfe"}',
        "null": b"null", "no choices": b'{"choices": []}', "choices of text": b'{"choices": "grasp"}', "NaN": b"NaN",
    }.items():  # fmt: skip
        talks[f"body is {name}"] = _whole(body)
    for name, talk in talks.items():
        yield Case("server", name, partial(_ask, talk))
