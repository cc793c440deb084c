"""Scenes are compiled once."""

from lerobot_llakey.diagnostics.worlds import world_of


def test_a_scene_is_built_once() -> None:
    assert world_of("move_block") is world_of("move_block")
