import numpy as np
import pytest

from lerobot_llakey import schema
from lerobot_llakey.policies.command.encoding import Encoder
from lerobot_llakey.policies.command.pose_text import PoseText
from lerobot_llakey.policies.command.small.encoder import WordEncoder
from lerobot_llakey.policies.command.small.tokenizer import WordTokenizer
from lerobot_llakey.policies.command.targets.action import ActionTarget


class Spelling(Encoder):
    """One token a character, as many tokenizers have it for digits."""

    pad_id, stop_id = 0, 1

    def prompts(self, images, prompts):
        raise NotImplementedError

    def answer(self, text):
        return [*map(ord, text), self.stop_id]

    def decode(self, ids):
        return "".join(chr(token) for token in ids if token > 1)


class Blind(Spelling):
    """Knows no digits."""

    def answer(self, text):
        return [7 for _ in text.split()] + [self.stop_id]


def encoders(text: PoseText) -> list[Encoder]:
    return [WordEncoder(WordTokenizer(text.numbers), 32, 16), Spelling()]


@pytest.mark.parametrize("index", [0, 1])
def test_every_walk_through_the_trie_is_a_pose_and_every_pose_a_walk(index):
    text = PoseText(40)
    encoder = encoders(text)[index]
    trie = ActionTarget(text).trie(encoder)
    rng = np.random.default_rng(0)
    for _ in range(50):
        ids: list[int] = []
        while following := trie.next_tokens(ids):
            ids.append(int(rng.choice(following)))
        said = encoder.decode(ids)
        text.decode(said)
        assert encoder.answer(said) == ids
    numbers = [f"{rng.integers(size):03d}" for size in text.sizes]
    ids = encoder.answer(" ".join(numbers))
    assert all(token in trie.next_tokens(ids[:place]) for place, token in enumerate(ids))


def test_a_tokenizer_that_cannot_write_numbers_is_refused():
    with pytest.raises(ValueError, match="use target=instruction"):
        ActionTarget(PoseText(4)).trie(Blind())


def test_a_batch_without_actions_is_refused():
    with pytest.raises(ValueError, match="Expected action in the batch"):
        ActionTarget(PoseText()).answers({schema.TASK: ["x"]})
