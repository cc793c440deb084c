"""A Hub on loopback, and what is sent to it."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from huggingface_hub import HfApi, constants
from huggingface_hub.utils import _http

from hub_server import Hub, hub_server


@pytest.fixture
def hub(monkeypatch: pytest.MonkeyPatch) -> Iterator[Hub]:
    """A Hub that this process may reach, without xet; a request that fails is tried again at once."""
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", False)
    monkeypatch.setattr(constants, "HF_HUB_DISABLE_XET", True)
    monkeypatch.setattr(_http, "time", SimpleNamespace(**vars(_http.time) | {"sleep": lambda _: None}))
    with hub_server() as served:
        yield served


@pytest.fixture
def api(hub: Hub) -> HfApi:
    """A client of that Hub."""
    return HfApi(endpoint=hub.url, token="hf_test")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three large files, one of several parts, a small one, and one that is nobody's business."""
    files = {"data/a.parquet": b"a" * 1000, "data/b.parquet": b"b" * 2_500_000, "videos/c.mp4": b"c" * 10}
    for name, content in (files | {"meta/info.json": b"{}", "notes.txt": b"secret"}).items():
        (tmp_path / "folder" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "folder" / name).write_bytes(content)
    return tmp_path / "folder"
