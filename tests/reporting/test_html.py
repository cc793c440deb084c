"""Pages escape what they show and need no other file."""

import numpy as np

from lerobot_llakey.reporting.html import html_page, html_picture, html_table


def test_texts_are_escaped() -> None:
    page = html_page("<script>", [html_table(("a<b",), [["<img>"]])])
    assert "<script>" not in page and "<img>" not in page
    assert "&lt;img&gt;" in page


def test_a_picture_stands_in_the_page() -> None:
    assert 'src="data:image/png;base64,' in html_picture(np.zeros((4, 4, 3), np.uint8), "a & b")
