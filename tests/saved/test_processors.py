import json
from pathlib import Path
from typing import Any

import pytest

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.saved.processors import OUR_STEPS, check_steps

FILE = Path("policy_preprocessor.json")


@pytest.mark.parametrize(
    "step",
    [
        {"class": "subprocess.Popen", "config": {"args": ["true"]}},
        {"registry_name": "to_batch_processor", "class": "subprocess.Popen"},
        {"registry_name": "tokenizer_processor"},
        {"registry_name": ["to_batch_processor"]},
        {"registry_name": None},
        {},
        {"registry_name": "to_batch_processor", "config": [1]},
        {"registry_name": "normalizer_processor", "state_file": "../../secret.safetensors"},
        {"registry_name": "normalizer_processor", "state_file": "/secret.safetensors"},
        {"registry_name": "normalizer_processor", "state_file": 5},
    ],
)
def test_what_is_no_known_step_with_its_state_beside_it_is_refused(step: dict[str, Any]) -> None:
    with pytest.raises(LlakeyError, match=r"policy_preprocessor\.json"):
        check_steps(FILE, {"steps": [{"registry_name": "to_batch_processor"}, step]}, OUR_STEPS)


@pytest.mark.parametrize("content", [{}, {"steps": {}}, {"steps": ["to_batch_processor"]}])
def test_what_is_no_list_of_steps_is_refused(content: dict[str, Any]) -> None:
    with pytest.raises(LlakeyError, match=r"Expected a list of processor steps in policy_preprocessor\.json"):
        check_steps(FILE, content, OUR_STEPS)


def test_registered_steps_of_other_policies_pass_where_any_may_be() -> None:
    check_steps(FILE, {"steps": [{"registry_name": "tokenizer_processor"}]})
    with pytest.raises(LlakeyError, match="which could run anything"):
        check_steps(FILE, {"steps": [{"class": "subprocess.Popen"}]})


def test_our_own_processors_are_made_of_our_steps(tmp_path: Path) -> None:
    shipped = Path(__file__).parents[2] / "checkpoints/llakey_small"
    for name in ("policy_preprocessor.json", "policy_postprocessor.json"):
        check_steps(shipped / name, json.loads((shipped / name).read_text()), OUR_STEPS)
