"""Pages that need nothing but themselves: one HTML file with its pictures inside, and no scripts."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

import cv2
import numpy as np

_STYLE = """body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; }
table { border-collapse: collapse; } th, td { text-align: left; padding: 4px 10px; border-bottom: 1px solid #ccc;
vertical-align: top; } figure { display: inline-block; margin: 0 8px 8px 0; } img { display: block; }
figcaption { font-size: 12px; opacity: .75; } .refused { color: #b91c1c; } .warning { color: #b45309; }"""


def html_page(title: str, parts: Sequence[str]) -> str:
    """A whole page of parts that are HTML already; the title is text."""
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style>'
    return f"<!doctype html><html><head>{head}</head><body><h1>{escape(title)}</h1>{''.join(parts)}</body></html>"


def html_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of texts; a row's first cell also names its style."""
    heads = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    lines = [
        f'<tr class="{escape(row[0])}">' + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    ]
    return f"<table><tr>{heads}</tr>{''.join(lines)}</table>"


def html_picture(picture: np.ndarray, caption: str, height: int = 180) -> str:
    """A picture (H, W, 3) uint8 RGB, shown so many pixels high, with a text below it."""
    content = base64.b64encode(cv2.imencode(".png", picture[..., ::-1])[1].tobytes()).decode()
    image = f'<img height="{height}" alt="{escape(caption)}" src="data:image/png;base64,{content}">'
    return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"
