"""Scenes are compiled once."""

from lerobot_llakey.diagnostics.simulations import simulation_of


def test_a_scene_is_built_once() -> None:
    assert simulation_of("move_block") is simulation_of("move_block")
