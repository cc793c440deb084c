"""One way to the Hub: a repository, the files of a folder, a card, and the tag that says all of it is there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
from huggingface_hub import HfApi
from huggingface_hub.errors import HfHubHTTPError, HFValidationError, OfflineModeIsEnabled
from huggingface_hub.utils import validate_repo_id

from lerobot_llakey.errors import LlakeyError, said

_CARD = "README.md"
_NOT_ALLOWED = (401, 403)
_FAILURES = (HfHubHTTPError, HFValidationError, OfflineModeIsEnabled, httpx.HTTPError, OSError, RuntimeError)
"""What huggingface_hub raises; it wraps what stopped the upload of a single file into a RuntimeError."""


@dataclass(frozen=True)
class Shipment:
    """What is to stand on the Hub.

    Attributes:
        folder: with the files.
        repo_id: name of the repository, as user/name.
        repo_type: "dataset" or "model".
        patterns: names of the files that are sent. Others in the folder stay here; others in the repository that match
            are removed there, since a dataset is every data file of its repository.
        card: Markdown of ``README.md``.
        private: whether the repository must be private.
        tag: that names the finished upload.
    """

    folder: Path
    repo_id: str
    repo_type: str
    patterns: tuple[str, ...]
    card: str
    private: bool
    tag: str | None = None


def require_repo_id(repo_id: str) -> None:
    """Refuse a name that the Hub would refuse, before any work.

    Raises:
        LlakeyError: if it is not of the form user/name.
    """
    try:
        validate_repo_id(repo_id)
    except HFValidationError as error:
        raise LlakeyError(f"Expected --repo_id as user/name, got {repo_id!r} ({said(error, 160)}).") from error
    if "/" not in repo_id:
        raise LlakeyError(f"Expected --repo_id as user/name, got {repo_id!r}; put your user name before it.")


def upload(shipment: Shipment, api: HfApi | None = None) -> str:
    """Send a shipment, or what of it is not there yet.

    Files come first, then the card, then the tag: whoever asks for the tag sees the whole or what was there before. An
    interrupted upload is taken up by the same call: huggingface_hub's ``upload_folder`` skips files that are committed
    and content that the Hub's storage holds. (Its ``upload_large_folder`` is deprecated, and leaves a cache in the
    folder.)

    Args:
        shipment: what to send.
        api: client of the Hub; by default that of ``HF_ENDPOINT`` and the token of this machine.

    Returns:
        The repository's address.

    Raises:
        LlakeyError: if the repository is public and must be private, or the Hub does not take it.
    """
    api = api or HfApi()
    where: dict[str, Any] = {"repo_id": shipment.repo_id, "repo_type": shipment.repo_type}
    with _sending(shipment):
        address = api.create_repo(**where, private=shipment.private, exist_ok=True)
        if shipment.private and not api.repo_info(**where).private:
            raise LlakeyError(
                f"Expected a private repository {shipment.repo_id}, got a public one; say --private=false to push into "
                "it, make it private, or choose another --repo_id."
            )
        api.upload_folder(
            **where,
            folder_path=shipment.folder,
            allow_patterns=list(shipment.patterns),
            delete_patterns=list(shipment.patterns),
            commit_message="Upload with llakey push",
        )
        last = api.upload_file(
            **where,
            path_or_fileobj=shipment.card.encode(),
            path_in_repo=_CARD,
            commit_message="Upload card with llakey push",
        )
        if shipment.tag is not None:
            _move_tag(api, shipment, shipment.tag, last.oid)
    return str(address)


def _move_tag(api: HfApi, shipment: Shipment, tag: str, commit: str) -> None:
    """Let a tag name a commit. The Hub moves none, so it is removed and made anew."""
    where: dict[str, Any] = {"repo_id": shipment.repo_id, "repo_type": shipment.repo_type}
    named = {one.name: one.target_commit for one in api.list_repo_refs(**where).tags}
    if named.get(tag) == commit:
        return
    if tag in named:
        api.delete_tag(**where, tag=tag)
    api.create_tag(**where, tag=tag, revision=commit)


@contextmanager
def _sending(shipment: Shipment) -> Iterator[None]:
    try:
        yield
    except LlakeyError:
        raise
    except _FAILURES as error:
        causes = [error, error.__cause__]
        statuses = [cause.response.status_code for cause in causes if isinstance(cause, HfHubHTTPError)]
        advice = "give the same command again: it goes on where it was"
        if any(status in _NOT_ALLOWED for status in statuses):
            advice = "log in with `hf auth login`, or set HF_TOKEN, as someone who may write there"
        elif isinstance(error, OfflineModeIsEnabled):
            advice = "unset HF_HUB_OFFLINE"
        raise LlakeyError(
            f"Expected the Hub to take {shipment.repo_id}, got {said(error.__cause__ or error, 200)}; {advice}."
        ) from error
