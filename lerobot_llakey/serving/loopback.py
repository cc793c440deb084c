"""A page served from a thread of its own, on this machine's loopback address alone."""

from __future__ import annotations

import importlib
import socket
import threading
import time
from typing import Any

from lerobot_llakey.bounds import require_count
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reason
from lerobot_llakey.serving.guard import App, Guard

LOOPBACK = "127.0.0.1"
_START_SECONDS = 60.0


def bind(port: int) -> socket.socket:
    """Take a port before anything else is done; nothing is answered yet.

    Args:
        port: on the loopback address; 0 for any free one.

    Returns:
        A socket that nobody else can have.

    Raises:
        LlakeyError: if there is no such port, it is taken, or the system does not give it.
    """
    require_count("--port", port, 0, 65535)
    taken = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        taken.bind((LOOPBACK, port))
        taken.listen()
    except OSError as error:
        taken.close()
        raise LlakeyError(f"Expected a free port, got {port} ({reason(error)}); give another --port.") from error
    return taken


class Served:
    """An application that is being served.

    Args:
        app: the application; it is guarded (see :class:`~lerobot_llakey.serving.guard.Guard`).
        taken: the socket, from :func:`bind`.

    Raises:
        LlakeyError: if it does not start.

    Attributes:
        address: of the page.
    """

    def __init__(self, app: App, taken: socket.socket) -> None:
        port = taken.getsockname()[1]
        self.address = f"http://{LOOPBACK}:{port}/"
        uvicorn: Any = importlib.import_module("uvicorn")  # comes with gradio, and with the extra "label"
        settings = uvicorn.Config(
            Guard(app, port), log_level="warning", ws="none", timeout_graceful_shutdown=1, server_header=False
        )
        self._server, self._socket = uvicorn.Server(settings), taken
        self._thread = threading.Thread(target=self._server.run, args=([taken],), name="page", daemon=True)
        self._thread.start()
        deadline = time.monotonic() + _START_SECONDS
        while not self._server.started and self._thread.is_alive() and time.monotonic() < deadline:
            time.sleep(0.02)
        if not self._server.started:
            self.close()
            raise LlakeyError(
                f"Expected the page at {self.address} to start, got none after {_START_SECONDS:g} s; start it again."
            )

    def close(self) -> None:
        """Answer no more."""
        self._server.should_exit = True
        self._thread.join()
        self._socket.close()
