import threading

import pytest
import torch

from lerobot_llakey import schema
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.chat.backend import ChatBackend
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy
from lerobot_llakey.policies.command.prompt import SYSTEM_MESSAGE, Prompt, answer_forms, answer_list

COLOURS = {"red": (230, 20, 20), "green": (20, 210, 20), "blue": (20, 20, 230), "yellow": (230, 230, 20)}
CAMERAS = ["left_shoulder", "front"]


def test_a_served_model_sees_the_images_and_reads_the_task(served_llava):
    base_url, model = served_llava
    settings = {"device": "cpu", "push_to_hub": False, "cameras": CAMERAS}
    config = LlakeyCommandConfig(backend="chat", base_url=base_url, model=model, **settings)
    config.chat.guidance = "none"
    policy = LlakeyCommandPolicy(config)
    tasks = ["grasp", "move", "grasp", "move"]
    images = torch.stack([(torch.tensor(paint) / 255)[:, None, None].expand(3, 16, 16) for paint in COLOURS.values()])
    batch = {schema.image_key(camera): images for camera in CAMERAS} | {schema.TASK: tasks}
    assert policy.next_instructions(batch) == [
        "grasp the red block",
        "move to the top of the green block",
        "grasp the blue block",
        "move to the top of the yellow block",
    ]
    assert (policy.chat.counts.requests, policy.chat.counts.unparsable, policy.chat.counts.unanswered) == (4, 0, {})


def _ask(config: LlakeyCommandConfig, rows: int = 1) -> list[str]:
    prompts = [Prompt(tuple(config.cameras), f"task {row}", "") for row in range(rows)]
    return ChatBackend(config).answers(torch.rand(rows, len(config.cameras), 3, 32, 32), prompts)


@pytest.mark.parametrize("guidance", ["none", "forms", "known"])
def test_the_system_message_says_what_answers_there_are(server, chat_config, guidance):
    chat_config.chat.guidance = guidance
    chat_config.instructions = ["grasp the red block", "raise the robotic arm"]
    _ask(chat_config)
    said = {
        "none": "",
        "forms": f"\n{answer_forms(BASIC_GRAMMAR)}",
        "known": f"\n{answer_list(chat_config.instructions)}",
    }
    system, user = server.requests[0]["messages"]
    assert system == {"role": "system", "content": SYSTEM_MESSAGE + said[guidance]}
    assert [part["type"] for part in user["content"]] == ["text", "image_url"] * 3 + ["text"]


def test_known_instructions_must_be_known(chat_config):
    chat_config.chat.guidance = "known"
    with pytest.raises(ValueError, match=r"got none; list them in --policy\.instructions"):
        ChatBackend(chat_config)


def test_answers_come_in_the_order_of_the_rows_from_so_many_requests_at_once(server, chat_config):
    chat_config.chat.max_parallel = 2
    server.together = threading.Barrier(2)
    assert _ask(chat_config, rows=6) == ["grasp the red block"] * 6
    assert server.most_under_way == 2
    asked = sorted(request["messages"][-1]["content"][-1]["text"] for request in server.requests)
    assert [text.split(",")[0] for text in asked] == [f"Task: task {row}" for row in range(6)]


def test_examples_come_before_the_question(server, chat_config, keysteps):
    chat_config.chat.examples = 2
    chat_config.chat.examples_repo_id, chat_config.chat.examples_root = keysteps.repo_id, str(keysteps.root)
    _ask(chat_config)
    messages = server.requests[0]["messages"]
    assert [message["role"] for message in messages] == ["system", *["user", "assistant"] * 2, "user"]
    assert {messages[2]["content"], messages[4]["content"]} <= {row[schema.INSTRUCTION] for row in keysteps}
