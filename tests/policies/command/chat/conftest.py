import json
import shutil
import socket
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
import torch
from PIL import Image
from transformers import AutoProcessor, LlavaForConditionalGeneration
from transformers.cli.serve import Serve

from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.prompt import Prompt

KEY = "sk-test-0123456789"
COLOURS = {"red": (230, 20, 20), "green": (20, 210, 20), "blue": (20, 20, 230), "yellow": (230, 230, 20)}
VIEWS = ("left_shoulder", "front")
CHAT_TEMPLATE = (
    "{% for message in messages %}{{ message.role }} : {% for part in message.content %}"
    "{% if part.type == 'image' %}<image> {% else %}{{ part.text }} {% endif %}{% endfor %}{% endfor %}"
    "{% if add_generation_prompt %}assistant : {% endif %}"
)


def completion(content: Any) -> str:
    return json.dumps({"object": "chat.completion", "choices": [{"index": 0, "message": {"content": content}}]})


@dataclass
class Reply:
    """What the server does with one request: ``drips`` its header or body a byte at a time, or never ends its body."""

    status: int = 200
    body: str = completion("grasp the red block")
    headers: dict[str, str] = field(default_factory=dict)
    hang: bool = False
    drips: str = ""
    endless: bool = False


class Server(ThreadingHTTPServer):
    """Answers the script's replies in turn, then the last one for ever, and keeps what it was sent."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.script: list[Reply] = [Reply()]
        self.requests: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.times: list[float] = []
        self.release = threading.Event()
        self.left = threading.Event()
        """Set when the other side has closed a connection on which a reply did not end."""
        self.sent = 0
        self.together: threading.Barrier | None = None
        self.under_way = self.most_under_way = 0
        self.lock = threading.Lock()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}/v1"


class Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"

    def do_POST(self) -> None:
        server = self.server
        request = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        with server.lock:
            server.times.append(time.monotonic())
            server.requests.append(request)
            server.headers.append({name.lower(): value for name, value in self.headers.items()})
            reply = server.script.pop(0) if len(server.script) > 1 else server.script[0]
            server.under_way += 1
            server.most_under_way = max(server.most_under_way, server.under_way)
        if server.together is not None:
            server.together.wait(timeout=20)
        with server.lock:
            server.under_way -= 1
        if reply.hang:
            server.release.wait(timeout=20)
        if reply.drips or reply.endless:
            return self._never_end(reply)
        body = reply.body.encode()
        self.send_response(reply.status)
        for name, value in {"Content-Type": "application/json", **reply.headers}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def _never_end(self, reply: Reply) -> None:
        """Send without end, until the other side has enough or the test is over."""
        self.close_connection = True
        head = b"HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n"
        self.wfile.write(head if reply.drips == "header" else head + b"\r\n")
        piece = b" " * 65536 if reply.endless else b"x"
        try:
            while not self.server.release.wait(timeout=0 if reply.endless else 0.02):
                self.wfile.write(piece)
                self.wfile.flush()
                self.server.sent += len(piece)
        except OSError:
            self.server.left.set()

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")


@pytest.fixture
def server() -> Iterator[Server]:
    server = Server()
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    yield server
    server.release.set()
    server.shutdown()
    server.server_close()
    thread.join()


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@pytest.fixture
def chat_settings(server: Server) -> dict[str, Any]:
    """Settings of a policy that asks the scripted server."""
    return {
        "device": "cpu",
        "push_to_hub": False,
        "image_size": 32,
        "backend": "chat",
        "base_url": server.url,
        "model": "tiny",
        "cameras": ["left_shoulder", "right_shoulder", "front"],
    }


@pytest.fixture
def chat_config(chat_settings: dict[str, Any]) -> LlakeyCommandConfig:
    config = LlakeyCommandConfig(**chat_settings)
    config.chat.max_attempts = 2
    return config


def lesson(task: str, colour: str) -> str:
    """What the served model has learned to say."""
    return f"grasp the {colour} block" if task == "grasp" else f"move to the top of the {colour} block"


@pytest.fixture(scope="session")
def served_llava(tiny_llava: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, str]]:
    """Address and name of a tiny LLaVA behind `transformers serve`, which names the colour that it sees."""
    folder = tmp_path_factory.mktemp("served") / "llava"
    shutil.copytree(tiny_llava, folder)
    processor = AutoProcessor.from_pretrained(folder)
    processor.chat_template = CHAT_TEMPLATE
    processor.save_pretrained(folder)
    _teach(folder, processor)
    port = free_port()
    serve = Serve(force_model=str(folder), host="127.0.0.1", port=port, device="cpu", non_blocking=True)
    deadline = time.monotonic() + 30
    while not serve.server.started and time.monotonic() < deadline:
        time.sleep(0.02)
    assert serve.server.started
    yield f"http://127.0.0.1:{port}/v1", str(folder)
    serve.kill_server()


def _teach(folder: Path, processor: Any) -> None:
    """Fit the model to all pairs of task and colour, as one batch: their prompts are equally long."""
    torch.manual_seed(0)
    model = LlavaForConditionalGeneration.from_pretrained(folder, dtype=torch.float32)
    tokenizer = processor.tokenizer
    pairs = [(task, colour) for task in ("grasp", "move") for colour in COLOURS]
    prompts = [_conversation(Prompt(VIEWS, task, ""), colour) for task, colour in pairs]
    inputs = processor.apply_chat_template(
        prompts, add_generation_prompt=True, tokenize=True, return_dict=True, return_tensors="pt"
    )
    answers = [lesson(*pair) + " </s>" for pair in pairs]
    ids = tokenizer(answers, padding=True, padding_side="right", return_tensors="pt")["input_ids"]
    sequences = torch.cat((inputs["input_ids"], ids), dim=1)
    labels = torch.full_like(sequences, -100)
    labels[:, -ids.shape[1] :] = ids.masked_fill(ids == tokenizer.pad_token_id, -100)
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-2)
    for _ in range(150):
        optimizer.zero_grad()
        loss = model(input_ids=sequences, pixel_values=inputs["pixel_values"], labels=labels).loss
        loss.backward()
        optimizer.step()
        if loss.item() < 0.02:
            break
    model.generation_config.eos_token_id = tokenizer.eos_token_id
    model.save_pretrained(folder)


def _conversation(prompt: Prompt, colour: str) -> list[dict[str, Any]]:
    shown: list[dict[str, Any]] = []
    for description in prompt.descriptions:
        image = Image.new("RGB", (16, 16), COLOURS[colour])
        shown += [{"type": "text", "text": description}, {"type": "image", "image": image}]
    return [
        {"role": "system", "content": [{"type": "text", "text": prompt.opening}]},
        {"role": "user", "content": [*shown, {"type": "text", "text": prompt.request_text}]},
    ]


@pytest.fixture
def reply() -> type[Reply]:
    return Reply
