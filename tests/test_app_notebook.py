"""`hertzchain.explore`: the page in a notebook, which exchanges messages with Python."""

import threading
import time

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.app import explore as explore_module
from hertzchain.app.explore import Conversation
from hertzchain.app.messages import Part
from hertzchain.app.results import Cancelled

TAPER = {"chain": {"taper": "forward-linear", "rate": 0.01, "beads": 30}}


class Sent:
    """Messages to the page."""

    def __init__(self):
        self.messages, self.done = [], threading.Event()

    def __call__(self, content, buffers):
        self.messages.append((content, buffers))
        if content.get("done"):
            self.done.set()

    def wait(self):
        assert self.done.wait(60.0)
        self.done.clear()
        return self.messages[-1]


def test_results_are_sent_in_parts():
    sent = Sent()
    talk = Conversation(TAPER, sent)
    body = {"session": "s", "number": 1, "document": TAPER, "draft": True}
    talk.receive({"type": "results", "id": 7, "body": body})
    assert sent.wait() == ({"id": 7, "done": True}, [])
    parts = [buffers[0] for _, buffers in sent.messages[:-1]]
    assert [b'"part": "%s"' % kind in raw for raw, kind in
            zip(parts, (b"beads", b"pulse", b"run"), strict=True)] == [True] * 3  # fmt: skip


def test_files_are_read_and_made():
    sent = Sent()
    talk = Conversation(TAPER, sent)
    talk.receive({"type": "export", "id": 1, "body": {"kind": "toml", "document": TAPER}})
    content, buffers = sent.wait()
    assert content["name"] == "chain.toml"
    talk.receive({"type": "read", "id": 2, "body": buffers[0].decode()})
    assert sent.wait()[0]["document"] == TAPER
    talk.receive({"type": "read", "id": 3, "body": "[chain]\nfile = 'x.csv'\n"})
    assert "cannot refer to files" in sent.wait()[0]["error"]
    talk.receive({"type": "results", "id": 4, "body": {}})
    assert "session" in sent.wait()[0]["error"]


@pytest.fixture
def occupied(monkeypatch):
    """A conversation whose threads compute both chains until they are stopped."""
    started = threading.Semaphore(0)

    def results(wanted, stop):
        if wanted.number == 0:
            started.release()
            while not stop():
                time.sleep(0.001)
            raise Cancelled
        yield Part({"part": "beads"})

    monkeypatch.setattr(explore_module, "results", results)
    sent = Sent()
    talk = Conversation(TAPER, sent)

    def ask(number):
        for slot in "AB":
            body = {"session": "s", "slot": slot, "number": number, "document": TAPER}
            talk.receive({"type": "results", "id": f"{slot}{number}", "body": body})

    def outcomes(count):
        end = time.monotonic() + 10.0
        while len(found := [each for each, _ in sent.messages if each.get("done")]) < count:
            assert time.monotonic() < end, sent.messages
            time.sleep(0.001)
        return {each["id"]: each.get("error") for each in found}

    ask(0)
    assert all(started.acquire(timeout=10.0) for _ in "AB")
    yield talk, ask, outcomes
    talk.close()


def test_newer_requests_stop_older_ones_that_occupy_all_threads(occupied):
    _, ask, outcomes = occupied
    ask(1)
    assert outcomes(4) == {"A0": "cancelled", "B0": "cancelled", "A1": None, "B1": None}


def test_simulations_stop_when_the_page_is_closed(occupied):
    talk, _, outcomes = occupied
    talk.close()
    assert outcomes(2) == {"A0": "cancelled", "B0": "cancelled"}


def test_the_widget_returns_the_chains_of_the_page():
    pytest.importorskip("anywidget", reason="hertzchain.explore not tested: no anywidget")
    view = hc.explore(hc.Chain.uniform(20), height=500)
    assert (repr(view.chain), view.other, view.height) == ("Chain(uniform, 20 beads)", None, 500)
    assert view.page.startswith("<!doctype html>")
    view.conversation.receive({"type": "state", "id": 1, "body": {"A": TAPER, "B": TAPER}})
    expected = hc.Chain.tapered("forward-linear", 0.01, beads=30)
    assert np.array_equal(view.chain.radii, expected.radii)
    assert np.array_equal(view.other.radii, expected.radii)
    for wrong in ("chain", 3):
        with pytest.raises(hc.InputError, match="requires a Chain"):
            hc.explore(wrong)
    with pytest.raises(hc.InputError, match="height"):
        hc.explore(height=0)
    view.close()
    assert view.conversation.closing.is_set()


def test_a_missing_package_is_named(monkeypatch):
    from hertzchain.app import explore as module

    module._widget_class.cache_clear()
    monkeypatch.setitem(__import__("sys").modules, "anywidget", None)
    with pytest.raises(hc.InputError, match=r"'\.\[notebook\]'"):
        hc.explore()
