"""``llakey drive``: a drive as a browser page on this machine's loopback address."""

from __future__ import annotations

import functools
import importlib
import os
import socket
import threading
import webbrowser
from collections.abc import Callable
from typing import Any

from lerobot_llakey.drive import markup
from lerobot_llakey.drive.session import Session
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.serving.loopback import Served, bind
from lerobot_llakey.sim.tasks import task_classes

_REFRESH_SECONDS = 0.25
_HOLDS = {"for one step": "once", "until it is done": "done"}


def require_gradio() -> Any:
    """The module ``gradio``, with its reports about use switched off.

    Raises:
        LlakeyError: if it is not installed.
    """
    os.environ["GRADIO_ANALYTICS_ENABLED"] = "False"
    try:
        return importlib.import_module("gradio")
    except ImportError as error:
        raise LlakeyError(
            "Expected the package gradio for the page of llakey drive, got none; "
            "pip install 'lerobot_policy_llakey[drive]', or add --terminal."
        ) from error


def build_page(session: Session) -> Any:
    """The page of a session, as a ``gradio.Blocks``; all its visitors share the drive.

    Raises:
        LlakeyError: if gradio is not installed.
    """
    gr = require_gradio()
    now = session.snapshot()

    def told(command: Callable[..., object]) -> Callable[..., None]:
        """The command, with what is wrong with it shown to the person."""

        @functools.wraps(command)
        def run(*arguments: Any) -> None:
            try:
                command(*arguments)
            except ValueError as error:
                session.tell(str(error))

        return run

    def start(name: str, scene: int | None) -> None:
        session.start(name, 0 if scene is None else scene)

    def correct(text: str, hold: str) -> str:
        try:
            session.correct(text, _HOLDS.get(hold, hold))  # type: ignore[arg-type]
        except ValueError as error:
            session.tell(str(error))
            return text
        return ""

    def refresh(shown: int) -> tuple[Any, ...]:
        moment = session.snapshot()
        if moment.version == shown:
            return (gr.skip(),) * 4
        return (
            markup.pictures_html(moment),
            markup.standing_html(moment),
            markup.table_html(moment),
            moment.version,
        )

    with gr.Blocks(analytics_enabled=False, title="llakey drive") as page:
        gr.HTML(markup.STYLE)
        version = gr.State(-1)
        with gr.Row():
            with gr.Column(scale=5):
                pictures = gr.HTML(markup.pictures_html(now))
            with gr.Column(scale=4):
                standing = gr.HTML(markup.standing_html(now))
                with gr.Row():
                    accept = gr.Button("Accept", variant="primary", elem_id="accept")
                    run = gr.Button("Run", elem_id="run", min_width=80)
                    pause = gr.Button("Pause", elem_id="pause", min_width=80)
                    stop = gr.Button("Stop", variant="stop", elem_id="stop", min_width=80)
                words = gr.Textbox(label="Say something else", placeholder="grasp the top handle", elem_id="words")
                with gr.Row():
                    hold = gr.Radio(list(_HOLDS), value=next(iter(_HOLDS)), show_label=False, container=False, scale=2)
                    say = gr.Button("Say it", elem_id="say", min_width=80)
                    withdraw = gr.Button("Take it back", elem_id="withdraw", min_width=80)
                goal = gr.Textbox(label="Another goal (empty: the scene's own)", elem_id="goal")
                change = gr.Button("Change the goal", elem_id="change")
                with gr.Row():
                    task = gr.Dropdown(list(task_classes()), value=now.task or None, label="Task", elem_id="task")
                    seed = gr.Number(value=now.seed, precision=0, minimum=0, label="Scene", elem_id="seed")
                begin = gr.Button("Start this scene", elem_id="begin")
        table = gr.HTML(markup.table_html(now))
        if session.known:
            with gr.Accordion("Instructions that the policy was trained on", open=False):
                gr.HTML(markup.known_html(list(session.known)))

        quiet: dict[str, Any] = {"show_progress": "hidden"}
        accept.click(told(session.step), **quiet)
        run.click(told(session.run), **quiet)
        pause.click(told(session.pause), **quiet)
        stop.click(told(session.stop), **quiet)
        gr.on([say.click, words.submit], correct, [words, hold], words, **quiet)
        withdraw.click(told(session.withdraw), **quiet)
        gr.on([change.click, goal.submit], told(session.change_goal), goal, **quiet)
        begin.click(told(start), [task, seed], **quiet)
        gr.Timer(_REFRESH_SECONDS).tick(refresh, version, [pictures, standing, table, version], **quiet)
    return page


def open_page(session: Session, taken: socket.socket | None = None, browser: bool = False) -> Served:
    """Serve the page of a session from a thread of its own.

    Args:
        session: with an episode started.
        taken: the port, from :func:`~lerobot_llakey.serving.loopback.bind`; any free one where None.
        browser: open it in the browser.

    Returns:
        The page, with its address, which its ``close()`` takes down.

    Raises:
        LlakeyError: if gradio is not installed.
    """
    gr = require_gradio()
    page = build_page(session)
    app = importlib.import_module("fastapi").FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    gr.mount_gradio_app(app, page, path="/", footer_links=[], run_history=False, ssr_mode=False, mcp_server=False)
    served = Served(app, bind(0) if taken is None else taken)
    if browser:
        webbrowser.open(served.address)
    return served


def serve(session: Session, taken: socket.socket, browser: bool) -> None:
    """Serve the page until the process is interrupted (Ctrl-C)."""
    page = open_page(session, taken, browser)
    print(f"llakey drive: {page.address} (Ctrl-C ends it)", flush=True)
    try:
        threading.Event().wait()
    finally:
        page.close()
