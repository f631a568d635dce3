"""A client of the app's server, which reads messages independently of `hertzchain.app`."""

import contextlib
import http.client
import json
import math
import struct

import numpy as np

from hertzchain.app.requests import Request
from hertzchain.app.results import results
from hertzchain.app.serve import RunningServer

TAPER = {"chain": {"taper": "backward-exponential", "rate": 0.05, "beads": 40}}
WALL = {"chain": {"taper": "uniform", "beads": 20, "right_wall": {"rigid": True}}}
STEEL = {
    "chain": {"taper": "forward-exponential", "rate": 0.03, "beads": 20, "radius": "9.3 mm",
              "materials": "steel-52100", "velocity": "0.02 m/s"}
}  # fmt: skip
KINDS = {"f8": "<f8", "f4": "<f4", "i2": "<i2"}


def unpacked(raw):
    """Headers and arrays of all messages, read independently of `Part`."""
    found, at = [], 0
    while at < len(raw):
        (length,) = struct.unpack_from("<I", raw, at)
        size, version = struct.unpack_from("<II", raw, at + 4)
        assert version == 1
        header = json.loads(raw[at + 12 : at + 12 + size])
        arrays = {}
        for name, kind, shape, offset in header["arrays"]:
            begin = at + 12 + size + offset
            # Relative to the message, arrays begin at multiples of 8 bytes.
            assert (begin - at - 4) % 8 == 0
            count = math.prod(shape)
            arrays[name] = np.frombuffer(raw, KINDS[kind], count, begin).reshape(shape)
        found.append((header, arrays))
        at += 4 + length
    return found


def computed(document, **more):
    request = Request.of({"session": "test", "number": 0, "document": document, **more})
    found = unpacked(b"".join(part.pack() for part in results(request, lambda: False)))
    return {header["part"]: (header, arrays) for header, arrays in found}


@contextlib.contextmanager
def serving(document=None):
    """A server that runs until the end of a ``with`` block."""
    found = RunningServer(0, document, warm_up=False)
    thread = found.start()
    try:
        yield found
    finally:
        found.stop()
        thread.join(5.0)
    assert not thread.is_alive()


class Client:
    """A browser of one page: it has the cookie."""

    def __init__(self, running):
        self.port = running.port
        self.cookie = running.app.guard.set_cookie.partition(";")[0]
        self.host = f"127.0.0.1:{running.port}"

    def ask(self, method, path, body=None, **changed):
        headers = {"Host": self.host, "Cookie": self.cookie, "Content-Type": "application/json"}
        headers |= {name.replace("_", "-"): value for name, value in changed.items()}
        link = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        given = {name: value for name, value in headers.items() if value is not None}
        raw = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
        link.putrequest(method, path, skip_host=True)
        for name, value in given.items():
            link.putheader(name, value)
        if raw is not None:
            link.putheader("Content-Length", str(len(raw)))
        link.endheaders(raw)
        answer = link.getresponse()
        answer.content = answer.read()
        link.close()
        return answer

    def results(self, document, number=1, **more):
        body = {"session": "s", "number": number, "document": document, **more}
        answer = self.ask("POST", "/api/results", body)
        assert answer.status == 200
        return unpacked(answer.content)
