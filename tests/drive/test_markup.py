"""The page's HTML shows the moment, and nothing that a person types becomes part of the page."""

from pathlib import Path

import numpy as np

from fakes_steps import a_step
from lerobot_llakey import schema
from lerobot_llakey.drive.driven_step import DrivenStep
from lerobot_llakey.drive.markup import known_html, pictures_html, standing_html, table_html
from lerobot_llakey.drive.snapshot import Snapshot
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.hierarchy.decision import Choice

EVIL = "<script>alert(1)</script>"


def test_standing_shows_goal_proposal_source_and_likelihood() -> None:
    parsed = BASIC_GRAMMAR.parse("grasp the lid")
    proposal = Choice("grasp the lid", parsed, "policy", "grab the lid", 0.42)
    moment = Snapshot(phase="waiting", goal="g", own_goal="g", proposal=proposal)
    html = standing_html(moment)
    assert "grasp the lid" in html and "the command policy, likelihood 42 %" in html and "yours" not in html
    changed = Snapshot(phase="over", goal="mine", own_goal="its own", folder=Path("here"), video=Path("here/a.mp4"))
    assert "yours; the scene&#x27;s: its own" in standing_html(changed).replace("'", "&#x27;")
    assert "Steps and video: here" in standing_html(changed)


def test_the_table_has_the_latest_step_first() -> None:
    steps = [DrivenStep(a_step(index=0), "", False), DrivenStep(a_step(index=1, source="person"), "unreachable", False)]
    html = table_html(Snapshot(steps=tuple(steps)))
    assert html.index("unreachable") < html.index("moved") and '<td class="person">person</td>' in html


def test_texts_are_escaped() -> None:
    step = DrivenStep(a_step(instruction=EVIL, source=EVIL), EVIL, False)
    proposal = Choice(EVIL, BASIC_GRAMMAR.parse("grasp the lid"), EVIL, EVIL, unparsable=True)
    moment = Snapshot(goal=EVIL, own_goal=EVIL + "!", note=EVIL, task=EVIL, proposal=proposal, steps=(step,))
    for html in (standing_html(moment), table_html(moment), known_html([EVIL])):
        assert "<script>" not in html and "&lt;script&gt;" in html


def test_all_pictures_are_there() -> None:
    pictures = {name: np.zeros((16, 16, 3), np.uint8) for name in (*schema.CAMERAS, "viewer")}
    html = pictures_html(Snapshot(pictures=pictures))
    assert html.count("data:image/jpeg;base64,") == 5 and "left shoulder" in html
    assert "preparing" in pictures_html(Snapshot())
