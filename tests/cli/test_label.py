"""``llakey label`` as a person uses it: a browser, a process that is killed, and the same command again."""

import csv
import hashlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

import pytest

from browsers import PATIENCE, find_browser
from fakes_recordings import fake_recording
from lerobot_llakey.cli import label
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import alone_with

ADDRESS = re.compile(r"llakey label: (http://127\.0\.0\.1:(\d+)/)")


@contextmanager
def labelling(root: Path, texts: Path, port: int = 0) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command in a process of its own, and the page's address; it is killed in the end."""
    verb = (sys.executable, "-m", "lerobot_llakey.cli.main", "label")
    options = ("--repo_id=me/r", f"--root={root}", f"--instructions={texts}", f"--port={port}", "--browser=false")
    process = subprocess.Popen((*verb, *options), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert process.stdout is not None
        found = next(filter(None, map(ADDRESS.match, process.stdout)), None)
        assert found is not None, "it ended without serving a page"
        yield process, found[1]
    finally:
        process.kill()
        process.wait()


def _rows(path: Path) -> list[tuple[int, str]]:
    with path.open(newline="") as file:
        return [(int(row["frame"]), row["instruction"]) for row in csv.DictReader(file) if row["episode"] == "0"]


def _hashes(root: Path) -> dict[str, str]:
    files = (path for path in sorted(root.rglob("*")) if path.is_file())
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.slow
def test_open_move_a_keyframe_type_kill_and_go_on(tmp_path: Path) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    path = find_browser()
    root, texts = tmp_path / "r", tmp_path / "texts.csv"
    fake_recording(root, episodes=2, scale=0.125, video=True)
    before = _hashes(root)
    asked: list[str] = []
    wrong: list[str] = []
    with playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=path, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1300, "height": 900})
        tab.set_default_timeout(PATIENCE)
        playwright.expect.set_options(timeout=PATIENCE)
        tab.on("request", lambda request: asked.append(request.url))
        tab.on("pageerror", lambda error: wrong.append(str(error)))
        with labelling(root, texts) as (process, address):
            tab.goto(address)
            found = _correct(tab, playwright.expect, texts)
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
        assert _rows(texts) == found
        # Typed while nothing answers: the page says so, and sends it once the command runs again.
        tab.locator(".segment input").nth(1).fill("grasp the red block")
        playwright.expect(tab.locator("#note")).to_contain_text("does not answer")
        with labelling(root, texts, port=urlparse(address).port or 0):
            playwright.expect(tab.locator("#saved")).to_have_text("saved in texts.csv")
            found[1] = (found[1][0], "grasp the red block")
            assert _rows(texts) == found
            tab.goto(address)  # as in a browser that was closed
            for place, (_, text) in enumerate(found):
                playwright.expect(tab.locator(".segment input").nth(place)).to_have_value(text)
        browser.close()
    assert not wrong and _hashes(root) == before
    assert {urlparse(url).hostname for url in asked if not url.startswith("data:")} == {"127.0.0.1"}


def _correct(tab: Any, expect: Any, texts: Path) -> list[tuple[int, str]]:
    """Move the first keyframe, add one, delete it, say what is outside the grammar and what is not."""
    segments, saved = tab.locator(".segment"), tab.locator("#saved")
    expect(segments.first).to_be_visible()
    count = segments.count()
    expect(tab.locator("canvas").first).to_have_js_property("width", 80)  # a picture is shown
    handle = tab.locator(".key").first
    expect(handle.locator("title")).to_have_text(re.compile("drag to move"))
    frame = int(re.findall(r", frame (\d+)", handle.locator("title").text_content())[0])
    box = handle.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 60
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x + 15, y, steps=3)
    tab.mouse.move(x + 30, y, steps=3)
    tab.mouse.up()
    expect(saved).to_have_text("saved in texts.csv")
    moved = _rows(texts)[0][0]
    assert frame < moved < frame + 15
    expect(tab.locator("#clock")).to_contain_text(f"frame {moved} of")
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("k")
    expect(segments).to_have_count(count + 1)
    tab.keyboard.press("Delete")
    expect(segments).to_have_count(count)
    first = segments.nth(0).locator("input")
    first.fill("grsp it please to")
    expect(segments.nth(0).locator(".wrong")).to_contain_text("grasp <thing>")
    first.fill("move to the top of the red block")
    expect(segments.nth(0).locator(".wrong")).to_be_hidden()
    first.press("Enter")
    second = segments.nth(1).locator("input")
    expect(second).to_be_focused()
    second.fill("grasp the re")
    expect(tab.locator(".offer").first).to_have_text("grasp the red block")
    second.press("ArrowDown")
    second.press("Enter")
    expect(second).to_have_value("grasp the red block")
    second.fill("grab the red block")
    expect(tab.locator("#timeline .label").nth(1)).to_have_text(re.compile("^grab"))
    expect(saved).to_have_text("saved in texts.csv")
    found = _rows(texts)
    assert found[0] == (moved, "move to the top of the red block") and found[1][1] == "grab the red block"
    second.press("Escape")
    second.press("Escape")
    tab.click("#play")
    expect(tab.locator("#clock")).not_to_contain_text(f"frame {moved + 1} of")
    return found


def _options(root: Path, texts: Path) -> label.LabelConfig:
    return label.LabelConfig(repo_id="me/r", root=root, instructions=texts, port=0, browser=False)


def test_a_second_process_at_the_same_file_is_refused(tmp_path: Path) -> None:
    texts = tmp_path / "texts.csv"
    texts.write_text("episode,frame,instruction\n")
    with (
        alone_with(texts, "--instructions"),
        pytest.raises(LlakeyError, match="got one that is still going; wait for it or give another --instructions"),
    ):
        label.run(_options(tmp_path / "r", texts))


def test_a_folder_in_the_files_place_is_refused(tmp_path: Path) -> None:
    (tmp_path / "texts.csv").mkdir()
    with pytest.raises(LlakeyError, match="Expected --instructions to be a file, got the folder"):
        label.run(_options(tmp_path / "r", tmp_path / "texts.csv"))


def test_a_file_of_another_kind_is_refused_before_the_page_is_there(tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match=r"Expected --instructions to be a file whose name ends with .csv"):
        label.run(_options(tmp_path / "r", tmp_path / "texts.json"))


def test_without_the_extra_one_sentence_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    with pytest.raises(LlakeyError, match=r"pip install 'lerobot_policy_llakey\[label\]'"):
        label.run(_options(tmp_path / "r", tmp_path / "texts.csv"))


def test_ctrl_c_says_how_far_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    root = tmp_path / "r"
    fake_recording(root, episodes=2, scale=0.05)

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(label, "_wait", interrupted)
    label.run(_options(root, tmp_path / "texts.csv"))
    assert "0 of 2 episodes complete; the same command goes on with" in capsys.readouterr().out
