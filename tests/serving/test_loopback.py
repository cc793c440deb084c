"""The port is taken, or refused in one sentence, before anything is loaded."""

import socket

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.serving.loopback import bind


@pytest.mark.parametrize("port", [-1, 65536, 99999, 1.5, "80"])
def test_a_port_that_does_not_exist_is_refused(port: int) -> None:
    with pytest.raises(LlakeyError, match=rf"Expected --port to be a whole number from 0 to 65535, got {port!r}"):
        bind(port)


def test_a_port_that_is_taken_is_refused() -> None:
    with bind(0) as first:
        port = first.getsockname()[1]
        with pytest.raises(LlakeyError, match=rf"Expected a free port, got {port} \(address already in use\)"):
            bind(port)


def test_it_is_open_to_this_machine_alone() -> None:
    with bind(0) as taken:
        assert taken.getsockname()[0] == "127.0.0.1" and taken.family == socket.AF_INET
