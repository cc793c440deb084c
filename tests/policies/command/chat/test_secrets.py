import base64

import pytest

from lerobot_llakey.policies.command.chat.secrets import repeats

KEY = "sk-Ab3/dE+9xYz_Q17"


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
