"""The addresses of the page, over HTTP: what they answer, and that they answer to the page alone."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
import pytest

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.labelling.server import FILES, make_app
from lerobot_llakey.labelling.session import LabelSession
from lerobot_llakey.serving.loopback import Served, bind


def _jpeg(episode: int, camera: str, frame: int) -> bytes:
    if frame > 39:
        raise LlakeyError("Expected a frame below 40, got another; load the page anew.")
    return f"{episode} {camera} {frame}".encode()


@pytest.fixture
def session(found: list[FoundKeyframes], tmp_path: Path) -> LabelSession:
    return LabelSession(found, tmp_path / "a.csv", BASIC_GRAMMAR)


@pytest.fixture
def client(session: LabelSession) -> Iterator[httpx.Client]:
    pictures: Any = SimpleNamespace(cameras=("front", "on the wrist"), jpeg=_jpeg)
    page = Served(make_app(session, pictures, "me/r"), bind(0))
    with httpx.Client(base_url=page.address, timeout=60) as client:
        yield client
    page.close()


def test_the_page_and_its_files_are_there_and_ask_nobody_else(client: httpx.Client) -> None:
    assert "<title>llakey label</title>" in client.get("/").text
    for name, kind in FILES.items():
        answer = client.get(f"/static/{name}")
        assert answer.status_code == 200 and answer.headers["content-type"].startswith(kind)
        assert "http://" not in answer.text.replace("http://www.w3.org/2000/svg", "") and "https://" not in answer.text
        assert "default-src 'self'" in answer.headers["content-security-policy"]
    for path in ("/static/server.py", "/static/..%2Fserver.py", "/static/../server.py", "/docs"):
        assert client.get(path).status_code == 404


def test_every_file_of_the_page_is_served() -> None:
    from lerobot_llakey import labelling

    folder = Path(labelling.__file__).parent / "static"
    assert {path.name for path in folder.iterdir()} == set(FILES)


def test_a_correction_is_in_the_file_when_it_is_answered(client: httpx.Client, session: LabelSession) -> None:
    told = client.post("/episodes/0/corrections", json={"do": "say", "frame": 10, "text": "grasp the cup"})
    assert told.status_code == 200 and told.json()["keyframes"][0]["valid"]
    assert "grasp the cup" in session.path.read_text()
    assert client.get("/episodes/0").json()["keyframes"][0]["text"] == "grasp the cup"
    offered = client.get("/episodes/1/suggestions", params={"segment": 0, "text": "gr"}).json()
    assert offered["texts"] == ["grasp the cup"] and not offered["valid"]
    assert client.post("/undo").json()["keyframes"][0]["text"] == ""
    assert client.post("/redo").json()["episode"] == 0


def test_pictures_may_be_kept_by_the_browser_for_this_run(client: httpx.Client) -> None:
    answer = client.get("/episodes/1/pictures/on%20the%20wrist/7")
    assert answer.content == b"1 on the wrist 7" and "immutable" in answer.headers["cache-control"]
    assert len(client.get("/dataset").json()["run"]) == 16
    for path in ("/episodes/1/pictures/front/40", "/episodes/9/pictures/front/0"):
        refused = client.get(path)
        assert refused.status_code == 404 and refused.text.startswith("Expected")
        assert "immutable" not in refused.headers["cache-control"]


@pytest.mark.parametrize("body", [b"", b"[]", b"{", b"\xff", b"[" * 20_000, b'{"do": "add", "frame": 40}'])
def test_what_makes_no_sense_is_answered_with_a_sentence(
    body: bytes, client: httpx.Client, session: LabelSession
) -> None:
    answer = client.post("/episodes/0/corrections", content=body)
    assert answer.status_code == 409 and answer.json()["wrong"].startswith("Expected")
    assert not session.path.exists()
    assert client.get("/episodes/9").json()["wrong"].startswith("Expected an episode of 3")
    assert client.get("/episodes/0/suggestions?segment=x").status_code == 200


def test_a_strangers_page_is_refused(client: httpx.Client, session: LabelSession) -> None:
    wanted = {"do": "add", "frame": 5}
    for headers in ({"Host": "evil.com"}, {"Origin": "http://evil.com"}, {"Origin": "null"}):
        for path in ("/", "/dataset", "/episodes/0", "/episodes/0/pictures/front/0"):
            answer = client.get(path, headers=headers)
            assert answer.status_code == 403 and "access-control-allow-origin" not in answer.headers
        assert client.post("/episodes/0/corrections", json=wanted, headers=headers).status_code == 403
        assert client.post("/undo", headers=headers).status_code == 403
    assert client.get("/episodes/0/corrections").status_code == 405
    assert not session.path.exists()
