"""The page, in a real browser without a screen: start, watch, correct, change the goal, stop."""

import importlib
import shutil
from typing import Any
from urllib.parse import urlparse

import pytest

from lerobot_llakey.drive.page import build_page, open_page, require_gradio
from lerobot_llakey.drive.session import Session
from lerobot_llakey.errors import LlakeyError

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PATIENCE = 120_000  # milliseconds; a busy machine must not fail the test


def _browser() -> str:
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"no browser on the path (looked for {', '.join(BROWSERS)}); apt-get install chromium")
    return found


@pytest.mark.slow
def test_start_watch_correct_change_the_goal_stop(session: Session) -> None:
    pytest.importorskip("gradio")
    playwright = pytest.importorskip("playwright.sync_api")
    path = _browser()
    session.start("open_drawer", 3)
    own_goal = session.settle().own_goal
    page, address = open_page(session, port=0)
    asked: list[str] = []
    try:
        with playwright.sync_playwright() as runner:
            browser = runner.chromium.launch(executable_path=path, args=["--no-sandbox"])
            tab = browser.new_page()
            tab.set_default_timeout(PATIENCE)
            playwright.expect.set_options(timeout=PATIENCE)
            tab.on("request", lambda request: asked.append(request.url))
            tab.goto(address)
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
