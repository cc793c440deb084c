"""A folder goes to the Hub whole, once, in any number of attempts."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from huggingface_hub import HfApi, constants

from hub_server import Hub
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.sharing.upload import Shipment, require_repo_id, upload

CARD = "---\nlicense: mit\n---\n# A card\n"


@pytest.fixture
def shipment(folder: Path) -> Shipment:
    return Shipment(folder, "me/things", "dataset", ("data/*", "meta/*", "videos/*"), CARD, private=True, tag="v3.0")


def contents(hub: Hub) -> dict[str, bytes]:
    return {path: content for path, (content, _) in hub.repos["datasets", "me/things"].head.items()}


def test_files_card_and_tag_arrive(shipment: Shipment, folder: Path, hub: Hub, api: HfApi) -> None:
    assert upload(shipment, api) == f"{hub.url}/datasets/me/things"
    repo, arrived = hub.repos["datasets", "me/things"], contents(hub)
    assert repo.private and repo.tags == {"v3.0": repo.refs["main"]}
    assert arrived.pop("README.md") == CARD.encode()
    del arrived[".gitattributes"]
    assert arrived == {
        str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*.*") if file.name != "notes.txt"
    }


def test_what_is_there_is_not_sent_again_and_what_is_gone_goes(
    shipment: Shipment, folder: Path, hub: Hub, api: HfApi
) -> None:
    upload(shipment, api)
    commits, sent = len(hub.repos["datasets", "me/things"].commits), len(hub.uploads)
    upload(shipment, api)
    assert (len(hub.repos["datasets", "me/things"].commits), len(hub.uploads)) == (commits, sent)
    (folder / "data/a.parquet").unlink()
    (folder / "meta/info.json").write_text('{"changed": 1}')
    upload(shipment, api)
    repo = hub.repos["datasets", "me/things"]
    assert len(hub.uploads) == sent and "data/a.parquet" not in repo.head
    assert contents(hub)["meta/info.json"] == b'{"changed": 1}'
    assert repo.tags["v3.0"] == repo.refs["main"]


@pytest.mark.parametrize("survived", [0, 1, 2])
def test_an_interrupted_upload_is_taken_up_again(survived: int, shipment: Shipment, hub: Hub, api: HfApi) -> None:
    hub.uploads_left = survived
    with pytest.raises(
        LlakeyError, match=r"Expected the Hub to take me/things, got .*500.*; give the same command again"
    ):
        upload(shipment, api)
    repo = hub.repos["datasets", "me/things"]
    assert len(hub.uploads) == survived and not repo.tags and set(repo.head) == {".gitattributes"}
    hub.uploads_left = None
    upload(shipment, api)
    assert len(hub.uploads) == 3 and set(Counter(hub.uploads).values()) == {1}
    assert repo.tags == {"v3.0": repo.refs["main"]} and "videos/c.mp4" in repo.head


def test_a_public_repository_gets_nothing_private(shipment: Shipment, hub: Hub, api: HfApi) -> None:
    upload(replace(shipment, private=False), api)
    sent = len(hub.uploads)
    with pytest.raises(
        LlakeyError, match=r"Expected a private repository me/things, got a public one; say --private=f"
    ):
        upload(shipment, api)
    assert len(hub.uploads) == sent


def test_who_may_not_write_is_told_to_log_in(shipment: Shipment, hub: Hub, api: HfApi) -> None:
    with pytest.raises(LlakeyError, match=r"take you/things, got .*; log in with `hf auth login`"):
        upload(replace(shipment, repo_id="you/things"), api)
    hub.token = "hf_another"
    with pytest.raises(LlakeyError, match=r"take me/things, got .*; log in with `hf auth login`"):
        upload(shipment, api)


def test_a_hub_out_of_reach_is_said(shipment: Shipment, hub: Hub, api: HfApi, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LlakeyError, match="give the same command again"):
        upload(shipment, HfApi(endpoint="http://127.0.0.1:9"))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    with pytest.raises(LlakeyError, match="unset HF_HUB_OFFLINE"):
        upload(shipment, api)


@pytest.mark.parametrize("name", ["things", "me/my/things", "me/th ings", "me/", "-me/things.git"])
def test_names_that_the_hub_refuses(name: str) -> None:
    with pytest.raises(LlakeyError, match="Expected --repo_id as user/name, got"):
        require_repo_id(name)
