"""A small Hub on loopback: what huggingface_hub needs of it to make, fill, tag, list and read repositories.

It speaks the protocol without xet, so clients must run with ``HF_HUB_DISABLE_XET=1``. Large files go through LFS, whole
or, above ``PART_BYTES``, in several. It counts what it was sent and can be told to fail.
"""

from __future__ import annotations

import base64
import json
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import unquote, urlsplit

from hub_state import Hub, Repo, entry_of, oid_of

PART_BYTES = 1_000_000
USER = "me"
_LARGE = (".parquet", ".mp4", ".safetensors", ".png")
_REPO = r"(?P<type>models|datasets)/(?P<id>[^/]+/[^/]+)"
_RESOLVE = re.compile(r"/(?P<prefix>datasets/)?(?P<id>[^/]+/[^/]+)/resolve/(?P<revision>[^/]+)/(?P<path>.+)")


@contextmanager
def hub_server() -> Iterator[Hub]:
    """Serve a Hub on a free port of this machine."""
    hub = Hub()
    server = ThreadingHTTPServer(("127.0.0.1", 0), type("Handler", (_Handler,), {"hub": hub}))
    server.daemon_threads = True
    hub.url = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        server.shutdown()
        server.server_close()


class _Handler(BaseHTTPRequestHandler):
    hub: Hub
    protocol_version = "HTTP/1.1"

    def log_message(self, *_: Any) -> None:
        """Say nothing."""

    def _answer(self, status: int, content: Any = None, **headers: str) -> None:
        body = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.send_response(status)
        for name, value in ({"Content-Length": str(len(body))} | headers).items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _serve(self) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        path = urlsplit(self.path).path
        with self.hub.lock:
            self.hub.requests.append((self.command, path))
            if (
                self.hub.token
                and self.headers.get("Authorization") != f"Bearer {self.hub.token}"
                and "/lfs/" not in path
            ):
                return self._answer(401, {"error": "Invalid credentials"})
            for method, pattern, handle in _ROUTES:
                matched = re.fullmatch(pattern, path)
                if method == self.command and matched:
                    return handle(self, body, **matched.groupdict())
            resolved = _RESOLVE.fullmatch(path)
            if resolved and self.command in ("GET", "HEAD"):
                return self._resolve(**resolved.groupdict())
            return self._answer(404, {"error": f"no {self.command} {path} here"})

    do_GET = do_HEAD = do_POST = do_PUT = do_DELETE = _serve  # noqa: N815 - http.server's names

    def _repo(self, kind: str, name: str) -> Repo | None:
        repo = self.hub.repos.get((kind, name))
        if repo is None:
            self._answer(404, {"error": "Repository not found"}, X_Error_Code="RepoNotFound")
        return repo

    def _tree(self, repo: Repo, revision: str) -> tuple[str, dict[str, tuple[bytes, bool]]] | None:
        sha = repo.find(revision)
        if sha is None:
            self._answer(404, {"error": "Revision not found"}, X_Error_Code="RevisionNotFound")
            return None
        return sha, repo.commits[sha]

    def _whoami(self, body: bytes) -> None:
        self._answer(200, {"type": "user", "name": USER, "orgs": [], "auth": {"type": "access_token"}})

    def _create(self, body: bytes) -> None:
        asked = json.loads(body)
        owner = asked.get("organization") or USER
        kind, name = f"{asked.get('type', 'model')}s", f"{owner}/{asked['name']}"
        url = f"{self.hub.url}/{'' if kind == 'models' else f'{kind}/'}{name}"
        if owner != USER:
            return self._answer(403, {"error": f"You don't have the rights to create a {kind[:-1]} under {owner}"})
        if (kind, name) in self.hub.repos:
            return self._answer(409, {"error": "You already created this repo", "url": url})
        repo = self.hub.repos[kind, name] = Repo(private=asked.get("visibility") == "private")
        repo.commit({".gitattributes": (b"*.parquet filter=lfs\n", False)})
        return self._answer(200, {"url": url, "name": name, "id": name})

    def _validate(self, body: bytes) -> None:
        card = json.loads(body)["content"]
        good = card.startswith("---\n") and "\n---\n" in card
        self._answer(200 if good else 400, {"errors": [] if good else [{"message": "no metadata"}], "warnings": []})

    def _info(self, body: bytes, type: str, id: str, revision: str = "main") -> None:
        repo = self._repo(type, id)
        found = repo and self._tree(repo, revision)
        if repo and found:
            files = [{"rfilename": path} for path in sorted(found[1])]
            self._answer(
                200, {"id": id, "sha": found[0], "private": repo.private, "siblings": files, "tags": [], "downloads": 0}
            )

    def _preupload(self, body: bytes, type: str, id: str, revision: str) -> None:
        repo = self._repo(type, id)
        if repo:
            files = []
            for file in json.loads(body)["files"]:
                mode = "lfs" if file["path"].endswith(_LARGE) else "regular"
                there = repo.head.get(file["path"])
                oid = oid_of(*there) if there else None
                files.append({"path": file["path"], "uploadMode": mode, "shouldIgnore": False, "oid": oid})
            self._answer(200, {"files": files})

    def _batch(self, body: bytes, id: str) -> None:
        answers = []
        for asked in json.loads(body)["objects"]:
            oid, size = asked["oid"], asked["size"]
            answer: dict[str, Any] = {"oid": oid, "size": size}
            if oid not in self.hub.objects:
                count = -(-size // PART_BYTES)
                upload: dict[str, Any] = {"href": f"{self.hub.url}/lfs/{oid}"}
                if count > 1:
                    urls = {str(part): f"{self.hub.url}/lfs/{oid}/{part}" for part in range(1, count + 1)}
                    upload = {"href": f"{self.hub.url}/lfs/{oid}", "header": {"chunk_size": str(PART_BYTES), **urls}}
                answer["actions"] = {"upload": upload}
            answers.append(answer)
        self._answer(200, {"transfer": "basic", "objects": answers})

    def _put(self, body: bytes, oid: str) -> None:
        self._answer(self.hub.take(oid, body), {})

    def _put_part(self, body: bytes, oid: str, part: str) -> None:
        self.hub.parts.setdefault(oid, {})[int(part)] = body
        self._answer(200, {}, ETag=f'"{oid}-{part}"')

    def _join(self, body: bytes, oid: str) -> None:
        parts = self.hub.parts.get(oid, {})
        self._answer(self.hub.take(oid, b"".join(parts[number] for number in sorted(parts))), {})

    def _commit(self, body: bytes, type: str, id: str, revision: str) -> None:
        repo = self._repo(type, id)
        if repo is None:
            return None
        tree = dict(repo.head)
        for line in body.splitlines():
            operation = json.loads(line)
            key, value = operation["key"], operation["value"]
            if key == "file":
                tree[value["path"]] = (base64.b64decode(value["content"]), False)
            elif key == "lfsFile":
                if value["oid"] not in self.hub.objects:
                    return self._answer(400, {"error": f"{value['path']} was not uploaded"})
                tree[value["path"]] = (self.hub.objects[value["oid"]], True)
            elif key == "deletedFile":
                del tree[value["path"]]
        sha = repo.commit(tree)
        return self._answer(200, {"commitUrl": f"{self.hub.url}/{id}/commit/{sha}", "commitOid": sha})

    def _list(self, body: bytes, type: str, id: str, revision: str) -> None:
        repo = self._repo(type, id)
        found = repo and self._tree(repo, revision)
        if found:
            self._answer(200, [entry_of(path, *file) for path, file in sorted(found[1].items())])

    def _refs(self, body: bytes, type: str, id: str) -> None:
        repo = self._repo(type, id)
        if repo:
            branches, tags = (
                [{"name": name, "ref": f"refs/{kind}/{name}", "targetCommit": sha} for name, sha in refs.items()]
                for kind, refs in (("heads", repo.refs), ("tags", repo.tags))
            )
            self._answer(200, {"branches": branches, "tags": tags, "converts": []})

    def _tag(self, body: bytes, type: str, id: str, revision: str) -> None:
        repo = self._repo(type, id)
        found = repo and self._tree(repo, revision)
        if repo and found:
            repo.tags[json.loads(body)["tag"]] = found[0]
            self._answer(200, {})

    def _untag(self, body: bytes, type: str, id: str, revision: str) -> None:
        repo = self._repo(type, id)
        if repo and repo.tags.pop(unquote(revision), None) is None:
            return self._answer(404, {"error": "no such tag"}, X_Error_Code="RevisionNotFound")
        return self._answer(200, {}) if repo else None

    def _resolve(self, prefix: str | None, id: str, revision: str, path: str) -> None:
        repo = self._repo("datasets" if prefix else "models", id)
        found = repo and self._tree(repo, revision)
        if not found:
            return None
        sha, tree = found
        if unquote(path) not in tree:
            return self._answer(404, {"error": "Entry not found"}, X_Error_Code="EntryNotFound", X_Repo_Commit=sha)
        content, large = tree[unquote(path)]
        return self._answer(200, content, ETag=f'"{oid_of(content, large)}"', X_Repo_Commit=sha)


_ROUTES = [
    ("GET", r"/api/whoami-v2", _Handler._whoami),
    ("POST", r"/api/repos/create", _Handler._create),
    ("POST", r"/api/validate-yaml", _Handler._validate),
    ("GET", rf"/api/{_REPO}", _Handler._info),
    ("GET", rf"/api/{_REPO}/revision/(?P<revision>[^/]+)", _Handler._info),
    ("GET", rf"/api/{_REPO}/tree/(?P<revision>[^/]+)", _Handler._list),
    ("GET", rf"/api/{_REPO}/refs", _Handler._refs),
    ("POST", rf"/api/{_REPO}/tag/(?P<revision>[^/]+)", _Handler._tag),
    ("DELETE", rf"/api/{_REPO}/tag/(?P<revision>[^/]+)", _Handler._untag),
    ("POST", rf"/api/{_REPO}/preupload/(?P<revision>[^/]+)", _Handler._preupload),
    ("POST", rf"/api/{_REPO}/commit/(?P<revision>[^/]+)", _Handler._commit),
    ("POST", r"/(?:datasets/)?(?P<id>[^/]+/[^/]+)\.git/info/lfs/objects/batch", _Handler._batch),
    ("PUT", r"/lfs/(?P<oid>[0-9a-f]{64})", _Handler._put),
    ("PUT", r"/lfs/(?P<oid>[0-9a-f]{64})/(?P<part>\d+)", _Handler._put_part),
    ("POST", r"/lfs/(?P<oid>[0-9a-f]{64})", _Handler._join),
]
