"""The noisy operator drives the simulator to success, and the truth of its recording holds."""

import numpy as np

from lerobot_llakey.diagnostics.keyframe_rules import replay
from lerobot_llakey.diagnostics.simulations import simulation_of
from lerobot_llakey.diagnostics.teleoperation import Sensors, drive
from lerobot_llakey.schema import scene_seed


def test_an_operator_does_the_task_and_its_truth_does_it_again() -> None:
    simulation = simulation_of("move_cup")
    recording = drive(simulation, 5000, 0, Sensors(10.0, 0.001))
    assert recording.success
    assert recording.truth[-1] == len(recording.motion) - 1
    assert all(np.diff(recording.truth) > 0)
    assert len(recording.truth) == len(recording.waypoints)
    assert replay(simulation, recording, recording.truth)


def test_an_operator_aims_before_a_short_move_rather_than_turning_back() -> None:
    recording = drive(simulation_of("place_shape_in_shape_sorter"), scene_seed("train", 0), 0, Sensors(10.0, 0.001))
    assert recording.success
    assert [waypoint.gripper_open for waypoint in recording.waypoints] == [True, False, False, False, True]
