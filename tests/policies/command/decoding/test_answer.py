from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.policies.command.decoding.answer import Answer, count_unparsable


def test_only_basic_actions_are_parsable():
    texts = ["grasp the red block", "sing a song", "", "grab the red block"]
    assert count_unparsable([Answer(text, 1.0) for text in texts], BASIC_GRAMMAR) == 2
