from concurrent.futures import ThreadPoolExecutor

from lerobot_llakey.policies.command.chat.counts import ChatCounts


def test_threads_count_together():
    counts = ChatCounts()

    def one(index: int) -> None:
        counts.asked()
        if index % 3:
            counts.answered(retries=1, parsable=index % 3 == 1)
        else:
            counts.failed("time-out" if index % 2 else "nonsense", retries=2)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(one, range(600)))
    assert counts == ChatCounts(600, 400, 800, 200, {"time-out": 100, "nonsense": 100})


def test_the_sum_of_failures_is_told():
    counts = ChatCounts()
    counts.asked()
    counts.asked()
    counts.failed("nonsense", 0)
    assert counts.failed("time-out", 0) == "2 of 2 requests unanswered so far"
