"""The page's addresses: its own files, pictures, and corrections in JSON. It stands behind the guard of ``serving``."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable
from functools import partial
from importlib import resources
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.labelling import answers
from lerobot_llakey.labelling.pictures import Pictures
from lerobot_llakey.labelling.session import LabelSession

FILES = {
    "page.html": "text/html",
    "page.css": "text/css",
    "page.js": "text/javascript",
    "player.js": "text/javascript",
    "timeline.js": "text/javascript",
    "segments.js": "text/javascript",
}
"""Of the folder ``static``, with their types."""
_HEADERS = {
    "content-security-policy": "default-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


def make_app(session: LabelSession, pictures: Pictures, repo_id: str) -> Starlette:
    """The application behind the page.

    Args:
        session: that the page shows and corrects.
        pictures: of the same dataset.
        repo_id: its name.
    """
    run = secrets.token_hex(8)  # in the pictures' addresses: another dataset's may be in the browser's cache

    def file(request: Request) -> Response:
        name = request.path_params.get("name", "page.html")
        if name not in FILES:
            return PlainTextResponse("Expected a file of the page, got another.", 404, _HEADERS)
        content = resources.files("lerobot_llakey.labelling").joinpath("static", name).read_bytes()
        return Response(content, headers=_HEADERS, media_type=FILES[name])

    def overview(request: Request) -> Response:
        return _json(lambda: answers.overview(session, pictures.cameras, repo_id) | {"run": run})

    def episode(request: Request) -> Response:
        return _json(lambda: answers.episode(session, request.path_params["episode"]))

    def suggest(request: Request) -> Response:
        query = request.query_params

        def told() -> dict[str, Any]:
            segment = query.get("segment", "0")
            number = int(segment) if segment.isdecimal() and len(segment) < 9 else 0
            return answers.suggestions(session, request.path_params["episode"], number, query.get("text", ""))

        return _json(told)

    def picture(request: Request) -> Response:
        asked = request.path_params
        try:
            session.keyframes(asked["episode"])
            data = pictures.jpeg(asked["episode"], asked["camera"], asked["frame"])
        except LlakeyError as error:
            return PlainTextResponse(str(error), 404, _HEADERS)
        kept = _HEADERS | {"cache-control": "private, max-age=86400, immutable"}
        return Response(data, headers=kept, media_type="image/jpeg")

    async def correct(request: Request) -> Response:
        body = await request.body()
        return await run_in_threadpool(
            _json, lambda: answers.correct(session, request.path_params["episode"], _wanted(body))
        )

    def back(request: Request, step: Callable[[], int]) -> Response:
        return _json(lambda: answers.keyframes(session, step()))

    routes = [
        Route("/", file),
        Route("/static/{name}", file),
        Route("/dataset", overview),
        Route("/episodes/{episode:int}", episode),
        Route("/episodes/{episode:int}/suggestions", suggest),
        Route("/episodes/{episode:int}/corrections", correct, methods=["POST"]),
        Route("/episodes/{episode:int}/pictures/{camera}/{frame:int}", picture),
        Route("/undo", partial(back, step=session.undo), methods=["POST"]),
        Route("/redo", partial(back, step=session.redo), methods=["POST"]),
    ]
    return Starlette(routes=routes)


def _wanted(body: bytes) -> dict[str, Any]:
    try:
        wanted = json.loads(body)
    except (ValueError, RecursionError):
        wanted = None
    if not isinstance(wanted, dict):
        raise LlakeyError("Expected a correction as a JSON object, got something else; load the page anew.")
    return wanted


def _json(answer: Callable[[], dict[str, Any]]) -> Response:
    """The answer, or the sentence that says what is wrong with what was asked."""
    try:
        return JSONResponse(answer(), headers=_HEADERS)
    except LlakeyError as error:
        return JSONResponse({"wrong": str(error)}, 409, _HEADERS)
