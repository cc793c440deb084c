from lerobot_llakey.policies.command.prompt import STOP, SYSTEM_MESSAGE, Prompt, sentences

CAMERAS = ("left_shoulder", "right_shoulder", "front")


def test_text_has_the_papers_order_and_one_image_a_view():
    text = Prompt(CAMERAS, "open the top drawer").text("<image>")
    assert text.startswith(SYSTEM_MESSAGE)
    assert text.count("<image>") == 3
    wanted = "Task: open the top drawer, please instruct the robotic arm's next action based on the current images."
    assert text.index("left shoulder") < text.index("right shoulder") < text.index("in front") < text.index(wanted)
    assert "Previous instruction" not in text and STOP not in text


def test_previous_instruction_is_told_or_none():
    assert "Previous instruction: grasp the cup" in Prompt(CAMERAS, "x", "grasp the cup").text("<image>")
    assert "Previous instruction: none." in Prompt(CAMERAS, "x", "").text("<image>")


def test_the_state_is_told_between_the_task_and_the_previous_instruction():
    assert Prompt(CAMERAS, "x", "grasp the cup", "001 002").request_text.endswith(
        "current images. Robot state: 001 002 Previous instruction: grasp the cup"
    )
    assert Prompt(CAMERAS, "x", state="001 002").request_text.endswith("current images. Robot state: 001 002")


def test_constant_pieces_are_all_among_the_sentences():
    prompt = Prompt((*CAMERAS, "elbow_left"), "stack the cups", "")
    pieces = {prompt.opening, *prompt.descriptions, *prompt.request} - {"stack the cups"}
    assert pieces == set(sentences(prompt.cameras))
    stated = Prompt(prompt.cameras, "stack the cups", "", "001")
    assert {*pieces, *stated.request} - {"stack the cups", "001"} == set(sentences(prompt.cameras, has_state=True))
