"""Threads record and ignore warnings independently of each other."""

import threading
import warnings
from concurrent.futures import ThreadPoolExecutor

import pytest

import hertzchain as hc
from hertzchain.errors import warn_user
from hertzchain.recorded_warnings import ignore_warnings, record_warnings
from hertzchain.threads import Threads


def test_what_one_thread_ignores_another_records():
    ignoring, warned = threading.Event(), threading.Event()

    def ignore():
        with ignore_warnings():
            ignoring.set()
            assert warned.wait(10)
            warn_user("ignored", UserWarning)

    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(ignore)
        assert ignoring.wait(10)
        with record_warnings() as recorded:
            warn_user("recorded", UserWarning)
        warned.set()
        future.result()
    assert [str(each) for each in recorded] == ["recorded"]


@pytest.mark.parametrize(
    ("categories", "left"), [((), []), ((hc.ModelRangeWarning,), ["a mistake"])]
)
def test_ignored_categories(categories, left):
    with record_warnings() as recorded, ignore_warnings(*categories):
        warn_user("outside", hc.ModelRangeWarning)
        warn_user("a mistake", hc.InputWarning)
    assert [str(each) for each in recorded] == left


def test_threads_record_where_their_work_was_submitted():
    with Threads(2) as pool, record_warnings() as recorded:
        assert list(pool.map(lambda text: warn_user(text, UserWarning), "ab")) == [None, None]
    assert sorted(map(str, recorded)) == ["a", "b"]
    with pytest.warns(UserWarning, match="^c$"):
        warn_user("c", UserWarning)


def test_warnings_of_other_packages_are_recorded_in_their_thread_only():
    shown = []
    with warnings.catch_warnings(), ThreadPoolExecutor(1) as pool:
        warnings.showwarning = lambda message, *_, **__: shown.append(str(message))
        with record_warnings() as outer:
            with record_warnings() as inner:
                warnings.warn("inside", hc.ModelRangeWarning, stacklevel=1)
            warnings.warn("around", UserWarning, stacklevel=1)
            pool.submit(warnings.warn, "elsewhere", UserWarning).result()
    assert [type(each) for each in (*inner, *outer)] == [hc.ModelRangeWarning, UserWarning]
    assert shown == ["elsewhere"]
