import pytest

from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.prompt import SYSTEM_MESSAGE
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer, grammar_words, known_words


@pytest.fixture
def tokenizer() -> WordTokenizer:
    return WordTokenizer(known_words(["open the top drawer", "close the jar"]), [SYSTEM_MESSAGE])


@pytest.mark.parametrize(
    "text",
    [
        "open the top drawer",
        "open the third drawer",
        "close the jar, please",
        "Öffne die Tür!",
        "a-b_c 42 <next goal>",
        "",
    ],
)
def test_every_text_survives_the_way_there_and_back(tokenizer, text):
    assert tokenizer.decode(tokenizer.encode(text)) == text


def test_a_known_word_is_one_token_and_letter_case_does_not_matter(tokenizer):
    assert len(tokenizer.encode("open the top drawer")) == 4
    assert tokenizer.encode("Open the TOP drawer") == tokenizer.encode("open the top drawer")
    assert len(tokenizer.encode("cup")) == 1 + len("cup")


def test_a_constant_sentence_is_one_token(tokenizer):
    assert len(tokenizer.encode(SYSTEM_MESSAGE)) == 1
    assert tokenizer.decode(tokenizer.encode(SYSTEM_MESSAGE)) == SYSTEM_MESSAGE


def test_decoding_stops_at_the_stop_token_and_skips_padding(tokenizer):
    first, second = tokenizer.encode("open"), tokenizer.encode("jar")
    ids = [tokenizer.begin_id, tokenizer.pad_id, *first, tokenizer.stop_id, *second]
    assert tokenizer.decode(ids) == "open"


def test_ids_are_distinct_and_within_the_vocabulary(tokenizer):
    ids = [
        *tokenizer.encode("open the top drawer close jar"),
        *tokenizer.encode("ÿ"),
        tokenizer.stop_id,
        tokenizer.pad_id,
    ]
    assert len(set(ids)) == len(ids)
    assert max(ids) < len(tokenizer)


def test_grammar_words_hold_verbs_and_poses_but_no_slots():
    words = grammar_words(BASIC_GRAMMAR)
    assert {"grasp", "release", "downward", "left", "side"} <= set(words)
    assert not {"thing", "pose", "target"} & set(words)
