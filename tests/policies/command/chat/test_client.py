import base64
import json
import logging
import sys
import traceback

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.command.chat import client as chat_client
from lerobot_llakey.policies.command.chat.client import MOST_BYTES, ChatClient
from lerobot_llakey.policies.command.chat.settings import ChatSettings

KEY = "sk-test-0123456789"
AT_ONCE = {"retry-after-ms": "1"}
QUESTION = [{"role": "user", "content": "Task: open the drawer"}]


@pytest.fixture
def client(server) -> ChatClient:
    return ChatClient(server.url, "tiny", ChatSettings(max_attempts=2, timeout_s=5.0), max_tokens=48)


def ask(client: ChatClient) -> str:
    return client.ask_all([QUESTION])[0]


def _reached(client: ChatClient) -> ChatClient:
    """The client after one good answer."""
    assert ask(client) == "grasp the red block"
    return client


def test_a_request_holds_what_the_settings_say(server, client):
    ask(client)
    assert server.requests == [{"model": "tiny", "messages": QUESTION, "max_tokens": 48, "temperature": 0.0}]
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"
    settings = ChatSettings(temperature=None, max_tokens_field="max_completion_tokens")
    ask(ChatClient(server.url, "tiny", settings, max_tokens=9))
    assert server.requests[1] == {"model": "tiny", "messages": QUESTION, "max_completion_tokens": 9}


def test_the_key_is_that_of_the_named_variable_and_none_is_needed(server, monkeypatch):
    monkeypatch.setenv("OTHER_KEY", "sk-other")
    ask(ChatClient(server.url, "tiny", ChatSettings(api_key_env="OTHER_KEY"), 48))
    monkeypatch.delenv("OTHER_KEY")
    ask(ChatClient(server.url, "tiny", ChatSettings(api_key_env="OTHER_KEY"), 48))
    assert [headers["authorization"] for headers in server.headers] == ["Bearer sk-other", "Bearer none"]


@pytest.mark.parametrize("status", [408, 429, 500, 503])
def test_what_may_pass_is_tried_again(server, client, reply, status):
    server.script = [reply(status, "{}", AT_ONCE), reply()]
    assert ask(client) == "grasp the red block"
    assert (client.counts.requests, client.counts.retries, client.counts.unanswered) == (1, 1, {})


def test_retry_after_is_waited_for(server, client, reply):
    server.script = [reply(429, "{}", {"Retry-After": "1.2"}), reply()]
    ask(client)
    assert server.times[1] - server.times[0] >= 1.2  # without it: half a second at most


@pytest.mark.parametrize("status", [429, 500])
def test_what_does_not_pass_is_counted_and_answered_with_nothing(server, client, reply, caplog, status):
    server.script = [reply(status, "{}", AT_ONCE)]
    assert ask(client) == ""
    assert (len(server.requests), client.counts.retries, client.counts.unanswered) == (2, 1, {f"status {status}": 1})
    assert f"(status {status}, 2 attempts); 1 of 1 requests unanswered so far" in caplog.text


def test_a_server_that_does_not_answer_in_time_is_counted(server, reply):
    server.script = [reply(hang=True)]
    client = ChatClient(server.url, "tiny", ChatSettings(max_attempts=2, timeout_s=0.1), 48)
    assert ask(client) == ""
    assert (len(server.requests), client.counts.unanswered) == (2, {"time-out": 1})


@pytest.mark.parametrize(
    "body",
    ["<html>welcome</html>", "", "[]", "{}", '{"choices": []}', '{"choices": [{"message": null}]}', '{"choices": [{}]}']
    + ['{"choices": [{"message": {"content": 7}}]}', "[" * 200_000, '{"a":' * 200_000],
)
def test_nonsense_is_counted_or_ends_a_run_that_never_had_an_answer(server, client, reply, body):
    server.script = [reply(body=body)]
    with pytest.raises(LlakeyError, match=r"got an answer that is no chat completion; start it or correct --policy"):
        ask(client)
    server.script = [reply(), reply(body=body)]
    assert ask(_reached(client)) == ""
    assert client.counts.unanswered == {"nonsense": 1}


def test_a_server_that_is_gone_is_counted_and_one_that_never_was_ends_the_run(server):
    client = _reached(ChatClient(server.url, "tiny", ChatSettings(max_attempts=1), 48))
    server.shutdown()
    server.server_close()
    client._background.result(client._client.close())
    fresh = ChatClient(server.url, "tiny", ChatSettings(max_attempts=1), 48)
    with pytest.raises(LlakeyError, match=r"Expected a chat-completions server at http://127.*, got no connection"):
        ask(fresh)
    client._client, client._background = fresh._client, fresh._background
    assert ask(client) == ""
    assert client.counts.unanswered == {"no connection": 1}


@pytest.mark.parametrize(
    ("status", "advice"),
    [
        (401, "set the environment variable OPENAI_API_KEY to a valid key"),
        (403, "set the environment variable OPENAI_API_KEY to a key that may"),
        (404, "check --policy.base_url and --policy.model=tiny"),
        (400, "its words repeat the API key and are left out; check the model and the chat settings"),
        (307, "it sends elsewhere; check --policy.base_url"),
    ],
)
def test_a_refusal_ends_the_run_in_one_sentence_without_the_key(server, client, reply, caplog, status, advice):
    caplog.set_level(logging.DEBUG)
    server.script = [reply(status, f'{{"error": {{"message": "no images with key {KEY}"}}}}')]
    with pytest.raises(LlakeyError) as caught:
        ask(client)
    assert f"got status {status}" in str(caught.value) and advice in str(caught.value)
    assert str(caught.value).count(". ") == 0 and len(server.requests) == 1
    shown = "".join(traceback.format_exception(caught.value)) + repr(client) + repr(client.counts)
    assert KEY not in shown
    # The client's own debug output holds what the server said, never what it was sent.
    assert f"Bearer {KEY}" not in caplog.text


@pytest.mark.parametrize("drips", ["header", "body"])
def test_a_server_that_drips_is_cut_off_at_the_time_limit(server, reply, drips):
    server.script = [reply(drips=drips)]
    client = ChatClient(server.url, "tiny", ChatSettings(max_attempts=2, timeout_s=0.3), 48)
    assert ask(client) == ""
    assert (len(server.requests), client.counts.unanswered) == (2, {"time-out": 1})
    assert server.left.wait(timeout=20)  # its connection is not left open


def test_a_body_without_end_is_left_at_the_limit(server, client, reply):
    server.script = [reply(), reply(endless=True)]
    assert ask(_reached(client)) == ""
    assert client.counts.unanswered == {"nonsense": 1} and server.left.wait(timeout=20)
    assert server.sent < 20 * MOST_BYTES  # with what the two sockets hold
    fresh = ChatClient(server.url, "tiny", ChatSettings(max_attempts=1), 48)
    with pytest.raises(LlakeyError, match="got an answer of more than 1 MB; start it or correct"):
        ask(fresh)


def test_all_attempts_together_are_bounded_whatever_retry_after_says(server, reply, monkeypatch):
    monkeypatch.setattr(chat_client, "LONGEST_WAIT", 0.2)
    server.script = [reply(429, "{}", {"Retry-After": "100"})]
    client = ChatClient(server.url, "tiny", ChatSettings(max_attempts=3, timeout_s=0.2), 48)
    assert ask(client) == ""
    assert (len(server.requests), client.counts.unanswered) == (1, {"time-out": 1})


def test_a_server_that_never_answers_again_ends_the_run(server, client, reply, monkeypatch):
    server.script = [reply(), reply(429, "{}", AT_ONCE)]
    assert ask(_reached(client)) == ""
    monkeypatch.setattr(chat_client, "GIVE_UP_SECONDS", 0.0)
    with pytest.raises(LlakeyError, match=r"got none for 0 s \(status 429; 2 of 3 requests unanswered so far\); start"):
        ask(client)


def test_an_answer_starts_the_patience_anew(server, client, reply, monkeypatch):
    server.script = [reply(429, "{}", AT_ONCE), reply(429, "{}", AT_ONCE), reply(), reply(429, "{}", AT_ONCE)]
    assert ask(client) == "" and ask(client) == "grasp the red block"
    assert client._silent_since is None


@pytest.mark.parametrize(
    "said",
    [KEY, KEY[::-1], KEY[6:16], base64.b64encode(f"is {KEY}".encode()).decode(), KEY.encode().hex(), "-".join(KEY)],
)
def test_an_answer_that_repeats_the_key_is_none_and_never_printed(server, client, reply, caplog, said):
    server.script = [reply(), reply(body=json.dumps({"choices": [{"message": {"content": said}}]}))]
    assert ask(_reached(client)) == "" and client.counts.unanswered == {"nonsense": 1}
    server.script = [reply(400, json.dumps({"error": {"message": f"I know: {said}"}}))]
    with pytest.raises(LlakeyError, match="its words repeat the API key and are left out"):
        ask(client)
    assert said not in caplog.text


def test_answers_in_parts_and_empty_ones_are_answers(server, client, reply):
    parts = '[{"type": "text", "text": "grasp the "}, {"type": "text", "text": "blue block"}]'
    number = '[{"text": 7}, {"text": ["a"]}, "b", {"text": "grasp the red block"}]'
    contents = (parts, "null", '"I am lost"', number)
    bodies = [f'{{"choices": [{{"message": {{"content": {content}}}}}]}}' for content in contents]
    server.script = [reply(body=body) for body in bodies]
    said = ["grasp the blue block", "", "I am lost", "grasp the red block"]
    assert [ask(client) for _ in bodies] == said
    assert (client.counts.unparsable, client.counts.unanswered) == (2, {})


def test_answers_outside_the_grammar_are_warned_about_ever_more_rarely(server, client, reply, caplog):
    server.script = [reply(body='{"choices": [{"message": {"content": "I am lost"}}]}')]
    for _ in range(9):
        ask(client)
    warnings = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    counts = [f"tiny answered 'I am lost', which is no basic action: {n} of {n} answers so far." for n in (1, 2, 4, 8)]
    assert warnings == counts


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "openai", None)
    with pytest.raises(LlakeyError, match=r"pip install 'lerobot_policy_llakey\[chat\]'"):
        ChatClient(None, "tiny", ChatSettings(), 48)
