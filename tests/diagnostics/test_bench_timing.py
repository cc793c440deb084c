import pytest

from lerobot_llakey.diagnostics.bench_policy import against
from lerobot_llakey.diagnostics.bench_timing import Timing, in_turns, precision
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.modeling_llakey_command import LlakeyCommandPolicy


def test_ways_take_turns() -> None:
    order: list[tuple[str, int]] = []
    timings = in_turns({name: lambda number, name=name: order.append((name, number)) for name in "ab"}, 2, "cpu")
    assert order == [(name, number) for number in (-2, -1, 0, 1) for name in "ab"]
    assert timings.keys() == {"a", "b"} and all(timing.seconds >= 0 for timing in timings.values())


def test_a_policy_computes_with_another_precision_for_a_while() -> None:
    policy = LlakeyCommandPolicy(LlakeyCommandConfig(device="cpu", image_size=32, dtype="auto", cameras=["front"]))
    with pytest.raises(RuntimeError), precision(policy, "bfloat16"):
        assert policy.config.dtype == "bfloat16"
        raise RuntimeError
    assert policy.config.dtype == "auto"


def test_times_are_told_against_the_first_way() -> None:
    ratios = against("step", {"auto": Timing(3.0, 4.0), "float32": Timing(2.0, 1.0)})
    assert ratios == {"step_time_against_float32": 1.5, "step_processor_time_against_float32": 4.0}
