"""A chat model on loopback names the actions of a made-up recording."""

import csv
import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from fakes_recordings import fake_recording
from lerobot_llakey.cli.annotate import AnnotateConfig, run
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.naming.chat import ChatOptions

SCALE = 0.05
pytest.importorskip("openai")


class Model(ThreadingHTTPServer):
    """Answers by what the question says of the motion; keeps all questions."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.questions: list[dict[str, Any]] = []
        self.answers = {"gripper closed": "Grasp the ball.", "moved up": "raise the robotic arm"}
        self.first = "lift the thing nicely"
        """Its answer to what it sees for the first time, unless that is named above."""


class _Handler(BaseHTTPRequestHandler):
    server: Model

    def do_POST(self) -> None:
        request = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.questions.append(request)
        messages = request["messages"]
        asked = messages[1]["content"][-1]["text"]
        known = [answer for words, answer in self.server.answers.items() if words in asked]
        text = known[0] if known else self.server.first if len(messages) == 2 else "move to the top of the ball"
        body = json.dumps({"choices": [{"index": 0, "message": {"content": text}}]}).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture
def model(monkeypatch: pytest.MonkeyPatch) -> Iterator[Model]:
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    server = Model()
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    yield server
    server.shutdown()
    server.server_close()
    thread.join()


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> LeRobotDataset:
    return fake_recording(tmp_path_factory.mktemp("chat") / "recording", "six_joints", scale=SCALE)


def config(recording: LeRobotDataset, model: Model | None, template: Path | None) -> AnnotateConfig:
    chat = ChatOptions("tiny", f"http://127.0.0.1:{model.server_address[1] if model else 9}/v1", timeout_s=20)
    return AnnotateConfig("me/recording", recording.root, template, "chat", chat, "me/x", recording.root.parent / "x")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_answers_fill_the_template_once_they_fit(recording: LeRobotDataset, model: Model, tmp_path: Path) -> None:
    run(config(recording, model, tmp_path / "texts.csv"))
    told = [row["instruction"] for row in rows(tmp_path / "texts.csv")]
    assert told == ["move to the top of the ball", "grasp the ball", "raise the robotic arm"] * 2
    assert len(model.questions) == 8  # the first answer in each episode is outside the grammar
    first, again = (next(q for q in model.questions if len(q["messages"]) == n) for n in (2, 4))
    pictures = [part for part in first["messages"][1]["content"] if part["type"] == "image_url"]
    assert len(pictures) == 2 and pictures[0]["image_url"]["url"].startswith("data:image/jpeg;base64,")
    assert "grasp {thing}" in first["messages"][0]["content"] or "grasp {" in first["messages"][0]["content"]
    steps = first["messages"][1]["content"][1]["text"].splitlines()
    assert len(steps) == 3 and "gripper closed" in steps[1] and "moved up" in steps[2]
    assert again["messages"][2] == {"role": "assistant", "content": "lift the thing nicely"}
    assert "nearest are" in again["messages"][3]["content"]
    last = model.questions[-1]["messages"][1]["content"][1]["text"].splitlines()
    assert last[1].endswith(": grasp the ball")


def test_an_answer_that_contradicts_the_gripper_stays_empty(
    recording: LeRobotDataset, model: Model, tmp_path: Path
) -> None:
    model.answers["gripper closed"] = "release the ball"
    run(config(recording, model, tmp_path / "texts.csv"))
    assert [row["instruction"] for row in rows(tmp_path / "texts.csv")][1::3] == ["", ""]
    assert any("The gripper is closed at the end" in json.dumps(question) for question in model.questions)


def test_a_server_that_is_not_there_and_missing_options_are_said(recording: LeRobotDataset, tmp_path: Path) -> None:
    with pytest.raises(LlakeyError, match=r"start it or correct --chat.base_url"):
        run(config(recording, None, tmp_path / "texts.csv"))
    with pytest.raises(LlakeyError, match=r"Expected --template with --instructions=chat"):
        run(config(recording, None, None))
    unnamed = config(recording, None, tmp_path / "texts.csv")
    unnamed.chat.model = None
    with pytest.raises(LlakeyError, match=r"--chat.model=gpt-4o"):
        run(unnamed)
    assert not (tmp_path / "texts.csv").exists()
