"""Parts of a task in threads: results, progress, failures and interrupts."""

import threading
import time

import pytest
from interruption import PROMPT

from hertzchain.threads import COUNT, STOP, run_in_threads


def test_each_part_is_computed_once_and_stored_in_the_calling_thread():
    stored, seen = {}, []

    def store(part, result):
        assert threading.current_thread() is threading.main_thread()
        stored[part] = result

    run_in_threads(
        [range(3), range(3, 5)], lambda part, _: sum(part), store, threads=2, of="items",
        total=6, done=1, progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    assert stored == {range(3): 3, range(3, 5): 7}
    assert seen[-1] == (6, 6)
    assert seen == sorted(seen)


def count_until_stopped(_part, signal):
    signal[COUNT] = 2
    while not signal[STOP]:
        time.sleep(0.01)


@pytest.mark.parametrize(("counted", "told"), [(True, "2 of 5"), (False, "0 of 5")])
def test_an_interrupt_stops_all_parts_and_states_the_progress(counted, told):
    def interrupt(_done, _total):
        raise KeyboardInterrupt

    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt) as caught:
        run_in_threads(
            [range(5)], count_until_stopped, lambda *_: None, threads=1, of="items", total=5,
            counted=counted, progress=interrupt,
        )  # fmt: skip
    assert time.monotonic() - begin < PROMPT
    assert caught.value.__notes__ == [f"stopped after {told} items"]


def test_a_part_that_fails_stops_the_others():
    def compute(part, signal):
        if part == range(1):
            raise ValueError("first part")
        count_until_stopped(part, signal)

    with pytest.raises(ValueError, match="first part") as caught:
        run_in_threads(
            [range(1), range(3)], compute, lambda *_: None, threads=2, of="items", total=4
        )
    assert caught.value.__notes__[0].endswith("of 4 items")
