import pytest

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.commanders.commander import Said
from lerobot_llakey.policies.hierarchy.commanders.oracle import OracleCommander


def test_passes_on_what_the_environment_says_to_the_rows_asked_for() -> None:
    texts = ["grasp the lid", "open the lid", "raise the robotic arm"]
    said = OracleCommander().ask({schema.ORACLE_INSTRUCTION: texts}, [2, 0], ["", ""])
    assert said == [Said("raise the robotic arm", "oracle"), Said("grasp the lid", "oracle")]


def test_an_environment_without_an_expert_is_named() -> None:
    with pytest.raises(ValueError, match=r"Expected 'observation.oracle_instruction'.*--env.oracle_instructions=true"):
        OracleCommander().ask({}, [0], [""])
