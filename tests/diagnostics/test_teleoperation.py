"""The noisy operator drives the simulator to success, and the truth of its recording holds."""

import numpy as np

from lerobot_llakey.diagnostics.keyframe_rules import replay, score_episode, summary, table
from lerobot_llakey.diagnostics.simulations import simulation_of
from lerobot_llakey.diagnostics.teleoperation import Sensors, drive


def test_an_operator_does_the_task_and_its_truth_does_it_again() -> None:
    simulation = simulation_of("move_cup")
    recording = drive(simulation, 5000, 0, Sensors(10.0, 0.001))
    assert recording.success
    assert recording.truth[-1] == len(recording.motion) - 1
    assert all(np.diff(recording.truth) > 0)
    assert len(recording.truth) == len(recording.waypoints)
    assert replay(simulation, recording, recording.truth)


def test_every_choice_of_rules_is_scored() -> None:
    scores = score_episode("open_drawer", "train", 5000, ("rest", "waypoints"), ("waypoints",))
    assert [score.rules for score in scores] == ["rest", "waypoints"]
    assert scores[0].replayed is None and scores[1].replayed is not None
    assert summary(scores[1:])["recall"] > 0.5
    assert "waypoints" in table(scores)
