import base64

import pytest

from lerobot_llakey.policies.command.chat.settings import ChatSettings, check_address, repeats

KEY = "sk-Ab3/dE+9xYz_Q17"


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"guidance": "hints"}, "`chat.guidance` out of"),
        ({"image_format": "gif"}, "`chat.image_format` out of"),
        ({"timeout_s": 0}, "timeout_s > 0"),
        ({"max_attempts": 0}, "max_attempts >= 1"),
        ({"max_parallel": 0}, "max_parallel >= 1"),
        ({"examples": -1}, "examples >= 0"),
        ({"examples": 2}, "`chat.examples_repo_id` to name a keysteps dataset for 2 examples"),
    ],
)
def test_wrong_settings_are_named(wrong, said):
    with pytest.raises(ValueError, match=said):
        ChatSettings(**wrong)


@pytest.mark.parametrize("address", [None, "http://127.0.0.1:8000/v1", "https://api.example.org/a@b/v1"])
def test_plain_addresses_are_taken(address):
    check_address(address, "tiny")


@pytest.mark.parametrize(
    "address", ["127.0.0.1:8000/v1", "ftp://host/v1", "http://me:sk-secret@host/v1", "http://host/v1?key=sk-secret"]
)
def test_odd_addresses_and_secrets_in_them_are_refused_without_repeating_them(address):
    with pytest.raises(ValueError, match="Expected `base_url`") as caught:
        check_address(address, "tiny")
    assert "sk-secret" not in str(caught.value)


def test_a_model_must_be_named():
    with pytest.raises(ValueError, match="Expected `model` to name the server's model"):
        check_address(None, None)


@pytest.mark.parametrize("before", ["", "a", "bc", "key: "])
def test_a_key_is_known_in_base64_wherever_it_stands(before):
    assert repeats(f"see {base64.b64encode(f'{before}{KEY} ok'.encode()).decode()}", KEY)


@pytest.mark.parametrize("text", [KEY, KEY.upper(), KEY[::-1], KEY[4:14], " ".join(KEY), KEY.encode().hex()])
def test_a_key_is_known_in_whole_and_in_part(text):
    assert repeats(f"the key is {text}!", KEY)


@pytest.mark.parametrize("text", ["", "grasp the red block", KEY[:6], "sk-"])
def test_other_words_are_no_key(text):
    assert not repeats(text, KEY)


def test_a_short_secret_counts_as_a_whole_and_an_empty_one_never():
    assert repeats("it is abc12", "abc12") and not repeats("it is abc1", "abc12")
    assert not repeats("anything", "") and not repeats("anything", "---")
