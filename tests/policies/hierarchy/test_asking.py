from collections.abc import Sequence

import numpy as np

from lerobot_llakey.policies.hierarchy.asking import ask_again, is_stuck
from lerobot_llakey.policies.hierarchy.commanders.commander import Commander, Said
from lerobot_llakey.policies.hierarchy.supervisor import Supervisor, SupervisorSettings


class Script(Commander):
    """Says what is written for each row, time after time, and notes how it was asked."""

    def __init__(self, *texts: Sequence[str]) -> None:
        self.texts = [list(row) for row in texts]
        self.asked: list[tuple[list[int], list[str], bool, list[int]]] = []

    def ask(self, batch, rows, previous, sample=False, seeds=()) -> list[Said]:
        self.asked.append((list(rows), list(previous), sample, list(seeds)))
        return [Said(self.texts[row].pop(0), "policy", 0.1) for row in rows]


def _supervisors(*moved: bool | None) -> list[Supervisor]:
    rows = [Supervisor(SupervisorSettings(), np.random.default_rng(seed)) for seed in range(len(moved))]
    for row, value in zip(rows, moved, strict=True):
        row.accept("grasp the lid")
        row.moved = value
    return rows


def _said(*texts: str) -> list[Said]:
    return [Said(text, "policy", 0.9) for text in texts]


def test_only_what_cannot_be_read_or_did_not_move_is_stuck() -> None:
    moved, still, first = _supervisors(True, False, None)
    assert not is_stuck(moved, Said("grasp the lid", "policy"))
    assert is_stuck(still, Said("grab the lid", "policy"))
    assert not is_stuck(still, Said("release the lid", "policy"))
    assert not is_stuck(first, Said("grasp the lid", "policy"))
    assert is_stuck(moved, Said("gibberish", "policy"))
    assert not is_stuck(still, Said("grasp the lid", "person")) and not is_stuck(still, Said("", "oracle"))


def test_asks_stuck_rows_until_something_else_is_said() -> None:
    script = Script([], ["grasp the lid", "raise the robotic arm"], ["release the lid"])
    said, asked = ask_again(
        script, {}, _said("grasp the lid", "grasp the lid", "mumble"), _supervisors(True, False, True), 3
    )
    assert [one.text for one in said] == ["grasp the lid", "raise the robotic arm", "release the lid"]
    assert asked == [0, 2, 1]
    assert [(rows, sample) for rows, _, sample, _ in script.asked] == [([1, 2], True), ([1], True)]
    assert script.asked[0][1] == ["grasp the lid"] * 2


def test_gives_up_after_its_attempts_and_keeps_the_best_it_heard() -> None:
    script = Script(["grab the lid"] * 3, ["mumble", "grasp the lid", "mutter"], ["mumble"] * 3)
    said, asked = ask_again(
        script, {}, _said("grasp the lid", "gibberish", "gibberish"), _supervisors(False, False, True), 3
    )
    assert [one.text for one in said] == ["grasp the lid", "grasp the lid", "gibberish"]
    assert [one.likelihood for one in said] == [0.9, 0.1, 0.9]
    assert asked == [3, 3, 3]


def test_seeds_come_from_the_row_alone() -> None:
    together, alone = Script(["mumble"] * 2, ["mumble"] * 2), Script(["mumble"] * 2)
    ask_again(together, {}, _said("gibberish", "gibberish"), _supervisors(True, True), 2)
    ask_again(alone, {}, _said("gibberish"), _supervisors(True), 2)
    seeds = [call[3] for call in together.asked]
    assert [row[0] for row in seeds] == [call[3][0] for call in alone.asked]
    assert len({seed for row in seeds for seed in row}) == 4
