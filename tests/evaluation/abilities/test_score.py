import pytest

from lerobot_llakey.evaluation.abilities.score import OUTSIDE, Score, macro


def counted(*answers: tuple[str, str]) -> Score:
    score = Score()
    for expected, answer in answers:
        score.add(expected, answer)
    return score


def test_verb_and_objects_are_counted_apart():
    score = counted(
        ("grasp the red block", "grasp the blue block"),
        ("grasp the red block", "release the red block"),
        ("move to the top of the red block", "move to the front of the red block"),
        ("grasp the red block", "sing a song"),
    )
    summary = score.summary()
    assert (summary["samples"], summary["exact"], summary["verb"], summary["objects"]) == (4, 0.0, 0.5, 0.5)
    assert summary["unparsable"] == 0.25
    assert len(summary["confusions"]) == 4
    assert score.verbs == {
        ("grasp", "grasp"): 1,
        ("grasp", "release"): 1,
        ("move", "move"): 1,
        ("grasp", OUTSIDE): 1,
    }


def test_wordings_of_one_instruction_and_equal_texts_outside_the_grammar_are_right():
    score = counted(("grasp the cup", "grab the cup"), ("wave", "wave"), ("wave", "nod"))
    assert (score.exact, score.unparsable) == (2, 1)
    assert list(score.confusions) == [("wave", "nod")]


def test_the_interval_holds_the_share_and_narrows_with_samples():
    few, many = (counted(*[("grasp the cup", "grasp the cup"), ("raise the robotic arm", "x")] * n) for n in (2, 50))
    for score in (few, many):
        low, high = score.summary()["interval"]
        assert low < 0.5 < high
    assert many.summary()["interval"][0] > few.summary()["interval"][0]


def test_scores_add_up():
    a, b = counted(("grasp the cup", "grasp the cup")), counted(("grasp the cup", "nod"))
    total = a + b
    assert (total.samples, total.exact, total.unparsable) == (2, 1, 1)
    assert total.verbs == {("grasp", "grasp"): 1, ("grasp", OUTSIDE): 1}


def test_the_average_counts_each_task_once_and_leaves_empty_ones_out():
    right, wrong = ("grasp the cup", "grasp the cup"), ("grasp the cup", "release the cup")
    average = macro([counted(right), counted(*[wrong] * 9), Score()])
    assert average["exact"] == pytest.approx(0.5)
    assert (average["tasks"], average["samples"], average["objects"]) == (2, 10, 1.0)
