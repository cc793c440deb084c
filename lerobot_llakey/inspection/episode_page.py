"""A contact sheet of one episode as a single HTML file: its keyframes, from every camera and in 3D, with their words.

Pictures are embedded; the page asks for no other file and runs no script.
"""

from __future__ import annotations

import base64
from html import escape

import cv2
import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.inspection.episode_look import EpisodeLook, Moment
from lerobot_llakey.inspection.oblique_view import ObliqueView
from lerobot_llakey.inspection.page import PREDICTED, TRUE

_TILE, _PANEL = 224, 336
"""Pixels of the pictures' height, and of the 3D panel's width."""
_SPAN = 0.8
"""Metres along the height of the 3D panel."""
_QUALITY = 85
"""Of the JPEG pictures, in per cent."""
_STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 1500px; padding: 0 1rem; }
h1 { font-size: 1.4rem; margin: 0; }
.facts, .time, figcaption { color: #77777f; font-size: .87rem; }
.line { display: flex; gap: 2px; height: 1.4rem; margin: 1rem 0 2rem; }
.line a { background: #4a78b5; border-radius: 3px; color: #fff; font-size: .8rem; min-width: 1.3rem; overflow: hidden;
  text-align: center; text-decoration: none; }
.line a:nth-child(even) { background: #6c95c9; }
section { border-top: 1px solid #8884; padding: 1rem 0; }
h2 { font-size: 1.1rem; margin: 0; }
.gripper { border-radius: 1rem; color: #fff; font-size: .8rem; margin-left: .5rem; padding: .1rem .6rem; }
.open { background: #2a8a4a; } .closed { background: #9a4a2a; }
.views { display: flex; flex-wrap: wrap; gap: .6rem; margin-top: .6rem; }
figure { margin: 0; } img { border-radius: 4px; display: block; height: 224px; image-rendering: auto; }
"""


def episode_page(look: EpisodeLook) -> str:
    """The page as HTML.

    Above, the task and a line of the segments as long as they take; below, the beginning and each keyframe: the
    instruction that led to it, time, gripper, all cameras, and the cloud with the hand as it is and as it was to be.
    """
    beginning = look.moment(0)
    moments = [look.moment(reached.frame) for reached in look.keyframes]
    centre = np.mean([reached.action[schema.POSITION] for reached in look.keyframes], axis=0)
    starts = [0, *(reached.frame for reached in look.keyframes[:-1])]
    links = "".join(
        f'<a href="#k{number}" style="flex-grow:{reached.frame - start}" '
        f'title="{escape(reached.instruction)}">{number}</a>'
        for number, (start, reached) in enumerate(zip(starts, look.keyframes, strict=True), start=1)
    )
    sections = [_section("start", "Beginning", beginning, None, centre)]
    for number, (moment, reached) in enumerate(zip(moments, look.keyframes, strict=True), start=1):
        title = f"{number}. {reached.instruction}"
        sections.append(_section(f"k{number}", title, moment, reached.action, centre))
    facts = (
        f"{look.name}, episode {look.episode}: {len(look)} frames at {look.fps:g} a second "
        f"({len(look) / look.fps:.1f} s), {len(look.keyframes)} keyframes"
    )
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(look.task)}</title><style>{_STYLE}</style></head>\n<body><h1>{escape(look.task)}</h1>"
        f'<div class="facts">{escape(facts)}</div><nav class="line" aria-label="segments">{links}</nav>\n'
        + "\n".join(sections)
        + "\n</body></html>\n"
    )


def _section(anchor: str, title: str, moment: Moment, reached: np.ndarray | None, centre: np.ndarray) -> str:
    """One moment; ``reached`` is the action (9,) that led to it, None at the beginning."""
    opening = float(moment.hand[schema.GRIPPER])
    is_open = opening > 0.9 if reached is None else bool(reached[schema.GRIPPER] > 0.5)
    word = "open" if is_open else "closed"
    figures = [_figure(_scaled(image), name.replace("_", " ")) for name, image in moment.images.items()]
    if len(moment.points):
        figures.append(_figure(_panel(moment, reached, centre), "cloud and hand"))
    return (
        f'<section id="{anchor}"><h2>{escape(title)}<span class="gripper {word}">gripper {word}</span></h2>'
        f'<div class="time">{moment.seconds:.1f} s, frame {moment.frame}, opening {opening:.2f}, hand at '
        f"{', '.join(f'{value:.3f}' for value in moment.hand[schema.POSITION])} m</div>"
        f'<div class="views">{"".join(figures)}</div></section>'
    )


def _panel(moment: Moment, reached: np.ndarray | None, centre: np.ndarray) -> np.ndarray:
    view = ObliqueView(centre, _SPAN, 2 * _PANEL, 2 * _TILE)  # at twice the size, for sharp screens
    panel = view.draw_cloud(moment.points, moment.colours, 5)
    if reached is not None:
        view.draw_gripper(panel, reached, TRUE, 8)
    view.draw_gripper(panel, np.append(moment.hand, 0.0), PREDICTED, 3)
    return panel


def _scaled(image: np.ndarray) -> np.ndarray:
    """A picture at least twice as high as it is shown, so that small ones are not blurred by the browser."""
    factor = max(1, -(-2 * _TILE // image.shape[0]))
    size = (image.shape[1] * factor, image.shape[0] * factor)
    return cv2.resize(image, size, interpolation=cv2.INTER_CUBIC) if factor > 1 else image


def _figure(image: np.ndarray, caption: str) -> str:
    whole, content = cv2.imencode(".jpg", image[..., ::-1], (cv2.IMWRITE_JPEG_QUALITY, _QUALITY))
    assert whole  # a picture in memory can always be encoded
    source = base64.b64encode(content.tobytes()).decode()
    name = escape(caption)
    return f'<figure><img src="data:image/jpeg;base64,{source}" alt="{name}"><figcaption>{name}</figcaption></figure>'
