"""Work divided among machines: every number is one shard's."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.shards import WHOLE, Shard


@given(st.integers(1, 40), st.integers(0, 400))
def test_shards_hold_every_number_once_in_order_and_are_of_equal_size(count: int, more: int) -> None:
    length = count + more
    shares = [Shard(number, count).of(length) for number in range(1, count + 1)]
    assert [number for share in shares for number in share] == list(range(length))
    assert max(map(len, shares)) - min(map(len, shares)) <= 1


def test_shards_are_read_as_typed_and_their_names_sort_as_they_do() -> None:
    assert Shard.parse("3/16") == Shard(3, 16) and str(Shard(3, 16)) == "3/16"
    names = [Shard(number, 16).name for number in range(1, 17)]
    assert names == sorted(names) and names[2] == "03-of-16"


@pytest.mark.parametrize("text", ["", "3", "0/4", "5/4", "-1/4", "1/0", "a/b", "1/2/3", "1.5/4"])
def test_what_is_no_shard_is_refused(text: str) -> None:
    with pytest.raises(LlakeyError, match=r"^Expected .*shard.*, got .*; .*\.$"):
        Shard.parse(text)


def test_more_shards_than_episodes_are_refused() -> None:
    with pytest.raises(LlakeyError, match="at most 3 shards of 3 episodes, got 1/4"):
        Shard(1, 4).of(3)


def test_the_whole_work_leaves_no_trace_in_records() -> None:
    assert WHOLE.recorded(7) == {}
    assert Shard(2, 3).recorded(7) == {"shard": {"number": 2, "count": 3, "episodes": 7}}
