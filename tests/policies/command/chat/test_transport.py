"""The limits of a server's answers are tested with the client."""

import pytest

from lerobot_llakey.policies.command.chat.transport import Background, completion_text, too_long


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ('"grasp it"', "grasp it"),
        ("null", ""),
        ('[{"text": "grasp "}, {"text": 7}, {"text": "it"}]', "grasp it"),
        ("7", None),
    ],
)
def test_the_text_of_a_completion_is_found(content: str, text: str | None) -> None:
    assert completion_text(f'{{"choices": [{{"message": {{"content": {content}}}}}]}}'.encode()) == text


def test_the_background_returns_results_and_passes_on_errors() -> None:
    async def work(fails: bool) -> int:
        if fails:
            raise ValueError(too_long(2_000_000))
        return 7

    background = Background()
    assert background.result(work(False)) == 7
    with pytest.raises(ValueError, match="an answer of more than 2 MB"):
        background.result(work(True))
