"""What the small Hub on loopback holds: repositories, large files, and a record of what it was asked."""

from __future__ import annotations

import hashlib
import threading
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote


@dataclass
class Repo:
    """One repository: commits of whole trees, each file its content and whether LFS holds it."""

    private: bool
    commits: dict[str, dict[str, tuple[bytes, bool]]] = field(default_factory=dict)
    refs: dict[str, str] = field(default_factory=dict)
    tags: dict[str, str] = field(default_factory=dict)

    def commit(self, tree: dict[str, tuple[bytes, bool]]) -> str:
        """Make a tree the head of main."""
        sha = hashlib.sha1(f"{len(self.commits)}{sorted(tree)}".encode()).hexdigest()
        self.commits[sha], self.refs["main"] = tree, sha
        return sha

    def find(self, revision: str) -> str | None:
        """The commit that a branch, a tag or a hash names."""
        revision = unquote(revision)
        return self.refs.get(revision) or self.tags.get(revision) or (revision if revision in self.commits else None)

    @property
    def head(self) -> dict[str, tuple[bytes, bool]]:
        """The files of main."""
        return self.commits[self.refs["main"]]


@dataclass
class Hub:
    """The server's state, for tests to look at and to set.

    Attributes:
        url: for ``HF_ENDPOINT``.
        repos: by type and name.
        objects: what LFS holds, by SHA-256.
        uploads: SHA-256 of each object that was sent, in order.
        requests: method and path of everything that was asked.
        uploads_left: so many objects are still taken, then all fail with status 500; None for ever.
        token: that every request must carry; None for none.
    """

    url: str = ""
    repos: dict[tuple[str, str], Repo] = field(default_factory=dict)
    objects: dict[str, bytes] = field(default_factory=dict)
    parts: dict[str, dict[int, bytes]] = field(default_factory=dict)
    uploads: list[str] = field(default_factory=list)
    requests: list[tuple[str, str]] = field(default_factory=list)
    uploads_left: int | None = None
    token: str | None = None
    lock: threading.RLock = field(default_factory=threading.RLock)

    def take(self, oid: str, content: bytes) -> int:
        """Keep an object, unless this was to fail; the status."""
        if self.uploads_left == 0:
            return 500
        if self.uploads_left is not None:
            self.uploads_left -= 1
        if hashlib.sha256(content).hexdigest() != oid:
            return 400
        self.objects[oid] = content
        self.uploads.append(oid)
        return 200


def oid_of(content: bytes, large: bool) -> str:
    """The name of a content: for LFS its SHA-256, else git's own."""
    if large:
        return hashlib.sha256(content).hexdigest()
    return hashlib.sha1(b"blob %d\0" % len(content) + content).hexdigest()


def entry_of(path: str, content: bytes, large: bool) -> dict[str, Any]:
    """A file as a listing shows it."""
    entry = {"type": "file", "path": path, "size": len(content), "oid": oid_of(content, False)}
    lfs = {"oid": oid_of(content, True), "size": len(content), "pointerSize": 134}
    return entry | ({"lfs": lfs} if large else {})
