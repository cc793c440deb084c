"""The contact sheet of an episode: one file, a section a keyframe, nothing asked from elsewhere, texts escaped."""

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np

from fakes import fake_keysteps
from lerobot_llakey.inspection.episode_look import EpisodeLook
from lerobot_llakey.inspection.episode_page import episode_page


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def test_the_page_shows_each_keyframe_and_needs_nothing_else(tmp_path: Path) -> None:
    look = EpisodeLook(fake_keysteps(tmp_path / "data", episodes=1, frames=6, cameras=("front", "wrist")), 0)
    page = episode_page(look)
    tags = Tags()
    tags.feed(page)
    assert [attributes["id"] for tag, attributes in tags.found if tag == "section"] == ["start", "k1", "k2"]
    sources = [str(attributes["src"]) for tag, attributes in tags.found if tag == "img"]
    assert len(sources) == 3 * 3, "two cameras and the cloud, at the beginning and at each keyframe"
    assert all(source.startswith("data:image/jpeg;base64,") for source in sources)
    assert not re.search(r"https?:|<script|<link|@import|url\(", page)
    for reached in look.keyframes:
        assert reached.instruction in page
    assert "gripper open" in page and "gripper closed" in page and "0.5 s, frame 5" in page
    encoded = np.frombuffer(base64.b64decode(sources[0].partition(",")[2]), np.uint8)
    picture = cv2.imdecode(encoded, cv2.IMREAD_COLOR)[..., ::-1]
    recorded = look.moment(0).images["front"]
    assert np.abs(cv2.resize(picture, (32, 32), interpolation=cv2.INTER_AREA) - recorded.astype(float)).mean() < 10


def test_texts_are_escaped(tmp_path: Path) -> None:
    look = EpisodeLook(fake_keysteps(tmp_path / "data", episodes=1, frames=2, cameras=("front",)), 0)
    look.task = "<script>alert(1)</script>"
    page = episode_page(look)
    assert "<script" not in page and "&lt;script&gt;" in page
