"""A moment of a drive as HTML: pictures, what comes next, what was done. Text of persons and models is escaped."""

from __future__ import annotations

import base64
from html import escape

import numpy as np

from lerobot_llakey import schema
from lerobot_llakey.drive.driven_episode import VIEWER
from lerobot_llakey.drive.driven_step import DrivenStep
from lerobot_llakey.drive.snapshot import Snapshot
from lerobot_llakey.drive.views import jpeg

STYLE = """<style>
footer { display: none !important; }
.drive img { display: block; width: 100%; border-radius: 6px; }
.drive .views { display: grid; grid-template-columns: repeat(4, 1fr); gap: 6px; margin-top: 6px; }
.drive figure { margin: 0; }
.drive figcaption { font-size: 12px; text-align: center; opacity: .75; }
.drive .card { border: 1px solid var(--border-color-primary); border-radius: 8px; padding: 10px 14px; }
.drive .goal { font-size: 15px; }
.drive .next { font-size: 22px; font-weight: 600; margin: 6px 0 2px; }
.drive .small { font-size: 13px; opacity: .8; }
.drive .note { min-height: 1.5em; margin-top: 6px; font-size: 14px; font-weight: 600; }
.drive table { width: 100%; border-collapse: collapse; font-size: 13px; }
.drive th, .drive td { text-align: left; padding: 4px 8px; border-bottom: 1px solid var(--border-color-primary); }
.drive .person { color: #b45309; } .drive .good { color: #15803d; } .drive .bad { color: #b91c1c; }
</style>"""
_PHASES = {
    "preparing": "preparing the scene ...",
    "waiting": "waiting for you",
    "moving": "moving ...",
    "over": "over",
    "failed": "failed",
}
_HEADS = ("step", "instruction", "source", "likelihood", "pose sent: x, y, z; quaternion xyzw; gripper", "result")


def pictures_html(now: Snapshot) -> str:
    """The human's picture, and below it the policy's views."""
    if not now.pictures:
        return '<div class="drive">preparing the scene ...</div>'
    views = "".join(_figure(now.pictures[camera], camera.replace("_", " ")) for camera in schema.CAMERAS)
    return f'<div class="drive">{_figure(now.pictures[VIEWER])}<div class="views">{views}</div></div>'


def standing_html(now: Snapshot) -> str:
    """Goal, proposal and note."""
    state = "running by itself" if now.running else _PHASES[now.phase]
    scenes = f' <span class="person">(yours; the scene\'s: {escape(now.own_goal)})</span>'
    changed = "" if now.goal == now.own_goal else scenes
    lines = [
        f'<div class="small" id="drive-state">{escape(now.task)}, scene {now.seed}: {state}</div>',
        f'<div class="goal" id="drive-goal">Goal: <b>{escape(now.goal)}</b>{changed}</div>',
        *_proposal(now),
        f'<div class="note" id="drive-note" role="alert">{escape(now.note)}</div>',
    ]
    if now.video is not None:
        lines.append(f'<div class="small" id="drive-video">Steps and video: {escape(str(now.folder))}</div>')
    return f'<div class="drive"><div class="card">{"".join(lines)}</div></div>'


def table_html(now: Snapshot) -> str:
    """The steps, the latest first."""
    heads = "".join(f"<th>{head}</th>" for head in _HEADS)
    rows = "".join(map(_row, reversed(now.steps)))
    return f'<div class="drive"><table id="drive-steps"><tr>{heads}</tr>{rows}</table></div>'


def known_html(known: list[str]) -> str:
    """The instructions that the policy was trained on."""
    return f'<div class="drive small">{"; ".join(map(escape, known))}</div>'


def _proposal(now: Snapshot) -> list[str]:
    proposal = now.proposal
    if proposal is None:
        return ['<div class="next" id="drive-next">-</div>']
    by = {"person": "you", "policy": "the command policy", "oracle": "the expert"}.get(proposal.source, proposal.source)
    likelihood = "" if proposal.likelihood is None else f", likelihood {100 * proposal.likelihood:.0f} %"
    said = f"; it said {proposal.said!r}, which is no basic action" if proposal.unparsable else ""
    kind = "next person" if proposal.source == "person" else "next"
    label = "Being carried out" if now.phase == "moving" else "Next, if you accept it"
    return [
        f'<div class="small">{label}:</div>',
        f'<div class="{kind}" id="drive-next">{escape(proposal.instruction)}</div>',
        f'<div class="small" id="drive-source">said by {escape(by + likelihood + said)}</div>',
    ]


def _row(step: DrivenStep) -> str:
    record = step.step
    kind = "good" if step.result == "success" else "bad" if step.failure else ""
    said = "person" if record.source == "person" else ""
    return (
        f'<tr><td>{record.index + 1}</td><td class="{said}">{escape(record.instruction)}</td>'
        f'<td class="{said}">{escape(record.source)}</td><td>{step.likelihood}</td><td>{step.pose}</td>'
        f'<td class="{kind}">{escape(step.result)}</td></tr>'
    )


def _figure(picture: np.ndarray, caption: str = "") -> str:
    data = base64.b64encode(jpeg(picture)).decode()
    below = f"<figcaption>{caption}</figcaption>" if caption else ""
    return f'<figure><img alt="{caption or "the scene"}" src="data:image/jpeg;base64,{data}">{below}</figure>'
