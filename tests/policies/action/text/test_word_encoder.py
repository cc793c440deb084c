import pytest
import torch

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.action.text.word_encoder import QueryPool, TextEncoder, TextRoles, hash_words, words_of


def words_of_the_grammar():
    texts = [text for template in BASIC_GRAMMAR.templates.values() for text in template.texts]
    colours = (
        "red maroon lime green blue navy yellow cyan magenta silver gray orange olive purple teal azure violet rose"
    )
    things = (
        "black white block target lid jar drawer handle cup bulb wine bottle rack top middle bottom left right side"
    )
    return sorted(
        {word for text in [*texts, colours, things] for word in text.replace("{", "").replace("}", "").split()}
    )


def test_no_two_words_of_the_grammar_are_confused():
    words = words_of_the_grammar()
    hashes = {tuple(pair.tolist()) for pair in hash_words(words, 1, 1024)[:, 0]}
    assert len(words) > 60
    assert len(hashes) == len(words)


def test_hashes_are_fixed_for_ever():
    # Saved checkpoints depend on these numbers.
    assert hash_words(["Grasp the RED block!"], 5, 1024).tolist() == [
        [[35, 751], [877, 559], [944, 164], [135, 516], [0, 0]]
    ]


def test_case_and_punctuation_do_not_matter():
    assert torch.equal(hash_words(["Raise, the arm."], 3, 64), hash_words(["raise the arm"], 3, 64))
    assert (hash_words(["one"], 3, 64)[0, 1:] == 0).all()


def test_padding_does_not_change_a_text():
    torch.manual_seed(0)
    encoder, pool = TextEncoder(32, 2, 64, 16).eval(), QueryPool(32, 2, 8)
    alone = pool(*encoder(["grasp the red lid"]))
    beside = pool(*encoder(["grasp the red lid", "move to the top of the red lid and grasp it"]))
    assert torch.allclose(alone[0], beside[0], atol=1e-5)
    assert not torch.allclose(beside[0], beside[1], atol=1e-3)


def test_word_order_matters():
    torch.manual_seed(0)
    encoder, pool = TextEncoder(32, 1, 64, 16).eval(), QueryPool(32, 2, 8)
    both = pool(*encoder(["place the red lid on the blue jar", "place the blue lid on the red jar"]))
    assert not torch.allclose(both[0], both[1], atol=1e-4)


def test_an_empty_text_is_finite():
    encoder, pool = TextEncoder(32, 1, 64, 16), QueryPool(32, 2, 8)
    assert pool(*encoder(["", "grasp"])).isfinite().all()


def test_two_texts_stand_side_by_side_and_swapping_them_is_seen():
    torch.manual_seed(0)
    encoder, roles, pool = TextEncoder(32, 1, 64, 16).eval(), TextRoles(2, 32), QueryPool(32, 2, 8)
    task, instruction = encoder(["close the red jar"]), encoder(["grasp the lid"])
    words, padding = roles([task, instruction])
    assert words.shape == (1, 7, 32) and padding.shape == (1, 7)
    swapped = pool(*roles([instruction, task]))
    assert not torch.allclose(pool(words, padding), swapped, atol=1e-3)


def test_a_long_task_does_not_cut_the_instruction():
    encoder, roles = TextEncoder(32, 1, 64, 4).eval(), TextRoles(2, 32)
    task = encoder(["a task as long"])
    both = [roles([task, encoder([text])])[0] for text in ("grasp the lid", "release the lid")]
    assert not torch.allclose(*both, atol=1e-3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Grasp the RED_block, 2x!", ["grasp", "the", "red", "block", "2x"]),
        ("a|b", ["a", "|", "b"]),
        ("抓住红色方块", ["抓", "住", "红", "色", "方", "块"]),
        ("赤いcubeを掴む", ["赤", "い", "cube", "を", "掴", "む"]),
        ("возьми красный куб", ["возьми", "красный", "куб"]),
        ("लाल घन उठाओ", ["लाल", "घन", "उठाओ"]),
        ("빨간 블록을 잡아", ["빨간", "블록을", "잡아"]),
        ("Öffne die Tür", ["öffne", "die", "tür"]),
        ("O\u0308ffne", ["öffne"]),
    ],
)
def test_words_have_letters_of_any_script(text, words):
    assert words_of(text) == words


def test_texts_of_other_scripts_are_told_apart():
    texts = ["抓住红色方块", "抓住蓝色方块", "захвати", "отпусти", "ارفع", "उठाओ", "उठो"]
    assert len({tuple(row.flatten().tolist()) for row in hash_words(texts, 8, 1024)}) == len(texts)


def test_words_that_would_be_cut_are_refused_and_so_is_a_text_without_any():
    with pytest.raises(LlakeyError, match=r"at most 3 words .*, got 4 in batch row 1 \(raise the arm"):
        hash_words(["raise", "raise the arm twice"], 3, 64)
    with pytest.raises(LlakeyError, match=r"letters or digits in a text, got '!\?' in batch row 0"):
        hash_words(["!?"], 3, 64)
