"""Several items at once: the same results in the same order, and no more items than threads at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest
from origami.core.numeric.threads import in_threads


@pytest.mark.parametrize("threads", [1, 2, 9])
def test_results_come_in_the_order_of_the_items(threads: int) -> None:
    def slow_first(item: int) -> int:
        time.sleep(0.02 if item == 0 else 0)
        return item**2

    assert list(in_threads(slow_first, range(7), threads)) == [item**2 for item in range(7)]
    assert list(in_threads(slow_first, [], threads)) == []


@pytest.mark.parametrize("threads", [1, 2])
def test_items_are_taken_in_the_callers_thread_as_they_are_needed(threads: int) -> None:
    taken: list[int] = []

    def items() -> Iterator[int]:
        for item in range(8):
            assert threading.current_thread() is threading.main_thread()
            taken.append(item)
            yield item

    for place, result in enumerate(in_threads(lambda item: item, items(), threads)):
        assert result == place
        assert len(taken) <= place + 1 + threads


@pytest.mark.parametrize("threads", [1, 2])
def test_a_failure_ends_it(threads: int) -> None:
    def fails(item: int) -> int:
        if item == 2:
            raise ValueError("third")
        return item

    seen = []
    with pytest.raises(ValueError, match="third"):
        for result in in_threads(fails, range(100), threads):
            seen.append(result)
    assert seen == [0, 1]


def test_it_may_be_left_in_the_middle() -> None:
    taken: list[int] = []

    def note(item: int) -> int:
        taken.append(item)
        return item

    results = in_threads(note, range(1000), 2)
    next(results)
    results.close()
    assert len(taken) < 10
