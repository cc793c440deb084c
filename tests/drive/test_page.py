"""The page, in a real browser without a screen: start, watch, correct, change the goal, stop."""

import contextlib
import importlib
import json
import warnings
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlparse

import httpx
import pytest

from browsers import PATIENCE, find_browser
from lerobot_llakey.drive.page import build_page, open_page, require_gradio
from lerobot_llakey.drive.session import Session
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.serving.loopback import Served


@pytest.mark.slow
def test_start_watch_correct_change_the_goal_stop(session: Session) -> None:
    pytest.importorskip("gradio")
    playwright = pytest.importorskip("playwright.sync_api")
    path = find_browser()
    session.start("open_drawer", 3)
    own_goal = session.settle().own_goal
    page = open_page(session)
    asked: list[str] = []
    try:
        with playwright.sync_playwright() as runner:
            browser = runner.chromium.launch(executable_path=path, args=["--no-sandbox"])
            tab = browser.new_page()
            tab.set_default_timeout(PATIENCE)
            playwright.expect.set_options(timeout=PATIENCE)
            tab.on("request", lambda request: asked.append(request.url))
            tab.goto(page.address)
            _drive(tab, playwright.expect, own_goal)
            browser.close()
    finally:
        page.close()
    now = session.settle()
    assert [step.step.source for step in now.steps] == ["policy", "person", "policy"]
    assert now.steps[-1].step.task == "open the bottom drawer" and now.video.exists()
    hosts = {urlparse(url).hostname for url in asked if not url.startswith(("data:", "blob:"))}
    assert hosts == {"127.0.0.1"}, f"The page asked others: {hosts}"


def _drive(tab: Any, expect: Any, own_goal: str) -> None:
    following, steps, note = tab.locator("#drive-next"), tab.locator("#drive-steps tr"), tab.locator("#drive-note")
    # Watch.
    expect(tab.locator("#drive-goal")).to_contain_text(own_goal)
    expect(following).to_have_text("move to the front of the top handle")
    expect(tab.locator("#drive-source")).to_have_text("said by the command policy, likelihood 90 %")
    assert tab.locator(".drive img").count() == 5
    before = tab.locator(".drive img").first.get_attribute("src")
    tab.click("#accept")
    expect(steps).to_have_count(2)
    assert tab.locator(".drive img").first.get_attribute("src") != before
    # Correct.
    tab.fill("#words textarea", "rase the robotic arm")
    tab.click("#say")
    expect(note).to_contain_text("Expected a basic action, got 'rase the robotic arm'")
    tab.fill("#words textarea", "lift the robotic arm")
    tab.click("#say")
    expect(following).to_have_text("raise the robotic arm")
    expect(tab.locator("#drive-source")).to_have_text("said by you")
    tab.click("#accept")
    expect(steps).to_have_count(3)
    # Change the goal.
    tab.fill("#goal textarea", "open the bottom drawer")
    tab.click("#change")
    expect(tab.locator("#drive-goal")).to_contain_text("open the bottom drawer (yours")
    tab.click("#accept")
    expect(steps).to_have_count(4)
    # Stop.
    tab.click("#stop")
    expect(tab.locator("#drive-state")).to_contain_text("over")
    expect(tab.locator("#drive-video")).to_contain_text("Steps and video")
    tab.click("#accept")
    expect(note).to_contain_text("got a drive that is over")


@pytest.fixture
def page(session: Session) -> Iterator[Served]:
    pytest.importorskip("gradio")
    session.start("open_drawer", 3)
    page = open_page(session)
    yield page
    page.close()


def _event(page: Served, name: str, data: list[Any]) -> dict[str, Any]:
    """What comes of an event of the page, sent as its own script would, by the name of the function behind it."""
    known = httpx.get(page.address + "config").json()["dependencies"]
    number = next(event["id"] for event in known if event["api_name"] == name)
    asked = {"data": data, "fn_index": number, "session_hash": "test"}
    httpx.post(page.address + "gradio_api/queue/join", json=asked).raise_for_status()
    answers = page.address + "gradio_api/queue/data?session_hash=test"
    with httpx.stream("GET", answers, timeout=PATIENCE / 1000) as told:
        messages = (json.loads(line.removeprefix("data:")) for line in told.iter_lines() if line.startswith("data:"))
        return next(message for message in messages if message["msg"] == "process_completed")


def test_the_page_answers_to_its_own_address_alone(page: Served, session: Session) -> None:
    assert httpx.get(page.address).status_code == 200
    evil = "http://evil.com"
    for headers in ({"Host": "evil.com"}, {"Host": "evil.com", "Origin": evil}, {"Origin": evil}, {"Origin": "null"}):
        for path in ("", "config", "gradio_api/info"):
            answer = httpx.get(page.address + path, headers=headers)
            assert answer.status_code == 403 and "access-control-allow-origin" not in answer.headers
        step = {"data": [], "fn_index": 0, "session_hash": "theirs"}
        assert httpx.post(page.address + "gradio_api/queue/join", json=step, headers=headers).status_code == 403
    assert not session.settle().steps


def test_the_page_takes_no_files_and_no_long_texts(page: Served) -> None:
    files = {"files": ("a.txt", b"words")}
    assert httpx.post(page.address + "gradio_api/upload", files=files).status_code == 403
    long = {"data": ["grasp " * 2_000_000], "fn_index": 0, "session_hash": "theirs"}
    with contextlib.suppress(httpx.TransportError):  # it may be refused while it is still being sent
        assert httpx.post(page.address + "gradio_api/queue/join", json=long).status_code == 413


def test_whatever_a_test_page_sends_is_answered_and_the_drive_goes_on(page: Served, session: Session) -> None:
    before = session.settle()
    for event, data in (
        ("correct", [None, None]),
        ("correct", [["raise the robotic arm"], {"a": 1}]),
        ("correct", ["rotate the " + "a to the " * 5000, "for one step"]),
        ("change_goal", [None]),
        ("change_goal", ["g" * 5000]),
        ("start", ["open_drawer", 1e300]),
        ("start", ["open_drawer", "three"]),
        ("start", [None, 3]),
    ):
        session.tell("")
        answered = _event(page, event, data)
        now = session.settle()
        assert now.phase == "waiting" and now.proposal is not None
        assert now.note.startswith("Expected") or not answered["success"]
        assert len(now.note) < 900 and (now.task, now.seed, now.goal) == (before.task, before.seed, before.goal)


def test_the_page_is_made_without_a_warning_before_the_first_scene_is_there(session: Session) -> None:
    pytest.importorskip("gradio")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        build_page(session)  # before any scene
        session.start("close_jar", 1)
        page = build_page(session)
    assert not [str(warning.message) for warning in seen if "Dropdown" in str(warning.message)]
    boxes = {part["props"].get("label"): part["props"] for part in page.config["components"]}
    assert boxes["Task"]["value"] == "close_jar" and boxes["Scene"]["value"] == 1


def test_without_gradio_one_sentence_says_what_to_install(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.import_module

    def missing(name: str, *rest: Any) -> Any:
        if name == "gradio":
            raise ModuleNotFoundError(name)
        return real(name, *rest)

    monkeypatch.setattr(importlib, "import_module", missing)
    for ask in (require_gradio, lambda: build_page(session)):
        with pytest.raises(LlakeyError, match=r"pip install 'lerobot_policy_llakey\[drive\]', or add --terminal"):
            ask()
