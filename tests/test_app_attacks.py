"""Requests that the server of `hertzchain app` rejects, and connections that it closes."""

import contextlib
import json
import socket
import time

import pytest
from app_client import TAPER, Client, serving

from hertzchain.app import connection, server


@pytest.fixture(scope="module")
def running():
    with serving(TAPER) as found:
        yield found


@pytest.fixture
def client(running):
    return Client(running)


@pytest.mark.parametrize(
    "changed",
    [
        {"Host": "example.org"},
        {"Host": "127.0.0.1:1"},
        {"Origin": "http://example.org"},
        {"Origin": "null"},
        {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site"},
        {"Cookie": None},
        {"Cookie": "hertzchain-1=x"},
    ],
    ids=str,
)
def test_foreign_requests_are_rejected(client, changed):
    body = {"session": "s", "number": 1, "document": TAPER}
    answer = client.ask("POST", "/api/results", body, **changed)
    assert answer.status == 403
    assert b"radii" not in answer.content


def test_a_request_without_host_is_rejected_by_the_parser(client):
    """It is sent at once: the server closes, and must have received all of it, or it resets."""
    head = f"POST /api/results HTTP/1.1\r\nCookie: {client.cookie}\r\n"
    body = json.dumps({"session": "s", "number": 1, "document": TAPER})
    with socket.create_connection(("127.0.0.1", client.port), timeout=30) as link:
        link.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n{body}".encode())
        answer = b"".join(iter(lambda: link.recv(65536), b""))
    assert answer.startswith(b"HTTP/1.1 400 ")
    assert b"radii" not in answer


def test_requests_of_the_page_are_accepted(client):
    own = {"Origin": f"http://{client.host}", "Sec_Fetch_Site": "same-origin"}
    assert client.ask("GET", "/api/about", **own).status == 200


def test_the_token_is_exchanged_for_a_cookie(running, client):
    token = running.app.guard.token
    answer = client.ask("GET", f"/?token={token}", Cookie=None)
    assert (answer.status, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert client.ask("GET", "/", Cookie=cookie.partition(";")[0]).status == 200
    wrong = token[:-1] + ("y" if token.endswith("x") else "x")
    assert client.ask("GET", f"/?token={wrong}", Cookie=None).status == 403
    assert client.ask("GET", f"/?token={token}", Cookie=None, Host="example.org").status == 403


def test_every_answer_has_strict_headers(client):
    for path in ("/", "/api/about", "/nothing", "/js/main.js"):
        answer = client.ask("GET", path)
        policy = answer.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert "server" not in answer.headers


@pytest.mark.parametrize(
    "path", ["/../pyproject.toml", "/js/../../server.py", "/%2e%2e/server.py", "//etc/passwd",
             "/js/", "/gallery.toml"],
)  # fmt: skip
def test_no_path_reaches_the_disk(client, path):
    assert client.ask("GET", path).status == 404


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"x" * 400_000, 413),
        (b"[" * 100_000, 400),
        (b"not json", 400),
        (b"[1]", 400),
        (b"\xff\xfe", 400),
        (b'{"number": NaN}', 400),
        ({"session": "s"}, 400),
        ({"session": "s", "number": -1}, 400),
        ({"session": "s" * 100, "number": 1}, 400),
        ({"session": "s", "number": 1, "slot": "C"}, 400),
        ({"session": "s", "number": 1, "frames": 10**9}, 400),
        ({"session": "s", "number": 1, "sensors": "all"}, 400),
    ],
    ids=lambda value: str(value)[:40],
)
def test_invalid_bodies_are_rejected(client, body, status):
    answer = client.ask("POST", "/api/results", body)
    assert answer.status == status
    assert b"Traceback" not in answer.content


def test_forms_of_other_sites_cannot_send_requests(client):
    body = {"session": "s", "number": 1, "document": TAPER}
    assert client.ask("POST", "/api/results", body, Content_Type="text/plain").status == 415


def test_the_server_is_not_reachable_from_outside(running):
    assert running.socket.getsockname()[0] == "127.0.0.1"


def test_silent_and_slow_clients_are_dropped(monkeypatch):
    monkeypatch.setattr(connection, "PATIENCE", 0.4)
    monkeypatch.setattr(server, "PATIENCE", 0.4)
    with serving() as found:
        client = Client(found)
        head = (f"POST /api/results HTTP/1.1\r\nHost: {client.host}\r\nCookie: {client.cookie}\r\n"
                "Content-Type: application/json\r\nContent-Length: 1000\r\n")  # fmt: skip
        for begun in (b"", b"GET / HT", head.encode(), head.encode() + b"\r\n{"):
            with socket.create_connection(("127.0.0.1", found.port), timeout=20.0) as link:
                link.sendall(begun)
                began, answer = time.monotonic(), b""
                with contextlib.suppress(ConnectionResetError):
                    while chunk := link.recv(65536):
                        answer += chunk
                assert time.monotonic() - began < 20.0
                assert answer == b"" or b"408" in answer
        assert client.ask("GET", "/").status == 200


def test_many_connections_leave_the_server_usable(monkeypatch):
    monkeypatch.setattr(connection, "PATIENCE", 1.0)
    with serving() as found, contextlib.ExitStack() as links:
        for _ in range(200):
            link = socket.create_connection(("127.0.0.1", found.port), timeout=5.0)
            links.enter_context(link)
        time.sleep(0.3)
        assert len(found.server.server_state.connections) <= connection.MAX_CONNECTIONS
        time.sleep(1.5)
        assert Client(found).ask("GET", "/").status == 200
