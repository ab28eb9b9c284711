"""Requests of others: none gets anything, whatever it names, says, sends or leaves unsaid."""

from __future__ import annotations

import base64
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import parse_qs, quote, urlsplit

import pytest
from lab_devices import REHEARSAL, lab_folder
from shown_lab import HOSTILE, shown

from inertialcal.core.errors import UsageError
from inertialcal.lab.live import server
from inertialcal.lab.live.server import CONNECTIONS, PAGES, TOKEN, live_page
from typed_commands import call

SECRETS = (b"drawTraces", b'"kind"', b"\r\n\r\n\x82", b"101 Switching")  # of what is given: page, state, frame, link


@dataclass
class Given:
    """Where the page is."""

    port: int
    token: str

    def send(self, data: bytes, patience: float = 20.0, drip: float = 0.0) -> bytes:
        """Return all that comes back until the server ends it, or nothing more is said."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=patience) as web:
            found = b""
            try:
                for i in range(0, len(data), 1 if drip else max(len(data), 1)):
                    web.sendall(data[i : i + (1 if drip else len(data))])
                    time.sleep(drip)
                while part := web.recv(65536):
                    found += part
                    if b"101 Switching" in found:
                        break
            except (ConnectionError, TimeoutError):
                pass
            return found


@dataclass
class Asked:
    """A request, good unless it says otherwise."""

    target: str
    host: str
    method: str = "GET"
    more: dict[str, str] = field(default_factory=dict)
    body: bytes = b""

    def data(self) -> bytes:
        lines = [f"{self.method} {self.target} HTTP/1.1", f"Host: {self.host}"]
        lines += [f"{name}: {value}" for name, value in self.more.items()]
        return "\r\n".join([*lines, "", ""]).encode("utf-8", "surrogateescape") + self.body


def link(given: Given, origin: str | None = "", token: str | None = None, **other: str) -> Asked:
    """Return the request of a WebSocket; an empty origin is the right one, None is none."""
    host = f"127.0.0.1:{given.port}"
    more = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
            "Sec-WebSocket-Key": base64.b64encode(bytes(16)).decode()}  # fmt: skip
    if origin is not None:
        more["Origin"] = origin or f"http://{host}"
    return Asked(f"/live?token={quote(given.token if token is None else token)}", host, more=more | other)


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Given]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server, "PATIENCE", 0.5)
        patch.delenv(TOKEN, raising=False)
        with shown(tmp_path_factory.mktemp("live"), names=HOSTILE, title=HOSTILE[1]) as (_, address):
            parts = urlsplit(address)
            assert parts.port is not None
            yield Given(parts.port, parse_qs(parts.query)["token"][0])


def hostile(given: Given, number: int) -> bytes:
    """Return the request of a number: its kind follows from it, the rest is drawn by it."""
    rng = random.Random(number)
    here, right = f"127.0.0.1:{given.port}", f"/?token={given.token}"
    hosts = [
        "evil.example", f"evil.example:{given.port}", "127.0.0.1.evil.example", "localhost.evil.example", "0.0.0.0",
        "169.254.169.254", "[::1]", "", "127.0.0.2", "127.1", "2130706433", "evil@127.0.0.1x", "127.0.0.1,evil",
    ]  # fmt: skip
    wrong = [
        "", given.token[:-1], given.token + "x", given.token.swapcase(), given.token[::-1], "%00", "a" * 4000, "*",
        "\u00e9", f"{given.token}%00", f"%20{given.token}", " or 1=1", "null", "undefined", "true",
    ]  # fmt: skip
    origins = [
        "http://evil.example", "null", None, f"https://{here}", "http://127.0.0.1", f"http://{here}1", "file://",
        f"http://{here}.evil.example", f"http://evil.example/{here}", f"http://{here}/", f"http://evil@{here}",
        f"http://localhost:{given.port}", f"http://{here}, http://evil.example", f"http://127.0.0.1:{given.port + 1}",
    ]  # fmt: skip
    places = [
        "/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/live/../page.js", "/page.html",
        "/page.js", "/static/page.js", "/..%5c..%5cpage.js", "/.git/config", "/server.py", "/content.py", "/%00",
        "/recording.mcap", "/LAB.toml", f"http://evil.example{right}", "/docs", "/openapi.json", "*",
    ]  # fmt: skip
    token, origin, host, place = rng.choice(wrong), rng.choice(origins), rng.choice(hosts), rng.choice(places)
    big = rng.randrange(20_000, 200_000)
    kinds = (
        lambda: Asked(right, host),
        lambda: Asked(f"/?token={quote(token, safe='%*')}", here),
        lambda: Asked("/", here, more={"Cookie": f"token={given.token}", "Authorization": f"Bearer {given.token}"}),
        lambda: Asked(f"{place}?token={given.token}", here),
        lambda: link(given, origin),
        lambda: link(given, token=token),
        lambda: Asked(link(given).target, host, more=link(given, f"http://{host}").more),
        lambda: Asked(right, here, more={"X-Large": "a" * big}),
        lambda: Asked(f"{right}&{'a' * big}", here),
        lambda: Asked(right, here, rng.choice(("POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH")),
                      {"Content-Length": str(big)}, b"a" * 100),
        lambda: Asked(right, f"{here}\r\nHost: evil.example"),
        lambda: Asked(right, host, more={"X-Forwarded-Host": here, "Forwarded": f"host={here}"}),
        lambda: link(given, f"http://{here}\r\nOrigin: http://evil.example"),
    )  # fmt: skip
    made = kinds[number % (len(kinds) + 2)]() if number % (len(kinds) + 2) < len(kinds) else None
    if made is not None:
        return made.data()
    if number % 2:
        return rng.randbytes(rng.randrange(1, 5000))  # no HTTP at all
    return f"GET {right} HTTP/1.1\r\nHost: {here}\r\nX".encode()  # and never goes on


@pytest.mark.parametrize("count", [30, pytest.param(300, marks=pytest.mark.slow)])
def test_hostile_requests_get_nothing(given: Given, count: int, capfd: pytest.CaptureFixture[str]) -> None:
    through = [i for i in range(count) if any(one in given.send(hostile(given, i)) for one in SECRETS)]
    assert through == []
    right = Asked(f"/?token={given.token}", f"127.0.0.1:{given.port}")
    assert SECRETS[0] in given.send(right.data())  # it lives, and who has the right to is answered
    assert capfd.readouterr().err == ""


def test_the_right_ones_are_answered(given: Given) -> None:
    for host in ("127.0.0.1", "localhost"):
        here = f"{host}:{given.port}"
        page = given.send(Asked(f"/?token={given.token}", here).data())
        assert page.startswith(b"HTTP/1.1 200")
        head, _, body = page.partition(b"\r\n\r\n")
        policy = head.decode().lower()
        (nonce,) = set(re.findall(r"'nonce-([^']+)'", head.decode()))
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert f"connect-src ws://{here}" in policy
        assert "cache-control: no-store" in policy
        assert body.count(f'nonce="{nonce}"'.encode()) == 2
        assert b"{nonce}" not in body
        assert b"{script}" not in body
        asked = link(given, f"http://{here}")
        asked.host = here
        assert b"101 Switching" in given.send(asked.data())


def test_slow_requests_are_cut_off(given: Given) -> None:
    """Each sends a byte now and then, for longer than the server waits; meanwhile others are answered."""
    data = f"GET /?token={given.token} HTTP/1.1\r\nHost: 127.0.0.1:{given.port}\r\n".encode()
    begin, found, ended = time.monotonic(), [], []

    def drip() -> None:
        found.append(given.send(data + b"X-Slow: " + b"a" * 1000, drip=0.05))
        ended.append(time.monotonic() - begin)

    threads = [threading.Thread(target=drip) for _ in range(10)]
    for one in threads:
        one.start()
    right = Asked(f"/?token={given.token}", f"127.0.0.1:{given.port}")
    assert SECRETS[0] in given.send(right.data())
    for one in threads:
        one.join()
    assert found == [b""] * 10
    assert max(ended) < 20.0  # all that is left to say would take 54 s


def test_connections_and_pages_are_counted(given: Given) -> None:
    held = [socket.create_connection(("127.0.0.1", given.port)) for _ in range(CONNECTIONS)]
    time.sleep(0.2)
    right = Asked(f"/?token={given.token}", f"127.0.0.1:{given.port}").data()
    assert given.send(right).startswith(b"HTTP/1.1 503")
    for one in held:
        one.close()
    pages = []
    for _ in range(PAGES):
        web = socket.create_connection(("127.0.0.1", given.port), timeout=20.0)
        web.sendall(link(given).data())
        assert b"101 Switching" in web.recv(65536)
        pages.append(web)
    assert b"403" in given.send(link(given).data())
    for web in pages:
        web.close()
    until = time.monotonic() + 20.0
    while b"101 Switching" not in given.send(link(given).data()) and time.monotonic() < until:
        time.sleep(0.05)
    assert time.monotonic() < until


def masked(body: bytes, code: int) -> bytes:
    """Return a frame of a client, RFC 6455, 5.2; its mask is zero."""
    size = len(body)
    length = struct.pack("!B", 128 + size) if size < 126 else struct.pack("!BH", 254, size)
    return struct.pack("!B", 128 + code) + length + bytes(4) + body


@pytest.mark.parametrize(
    "frame", [masked(b"eval", 1), masked(b"600 nan", 1), masked(b"\x00\xff", 2), masked(b"a" * 300, 1), b"\xff" * 20],
    ids=["word", "number", "bytes", "large", "no frame"],
)  # fmt: skip
def test_a_page_that_asks_for_something_else_is_closed(given: Given, frame: bytes) -> None:
    with socket.create_connection(("127.0.0.1", given.port), timeout=20.0) as web:
        web.sendall(link(given).data())
        assert b"101 Switching" in web.recv(65536)
        web.sendall(frame)
        found = b""
        try:
            while part := web.recv(65536):
                found += part
                if found[:1] == b"\x88":
                    break
        except ConnectionError:
            pass
        assert found[:1] in (b"\x88", b"")  # a closing, nothing else


def test_it_is_on_this_computer_alone(given: Given) -> None:
    hosts = {one[4][0] for one in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {"127.0.0.1"}
    for host in hosts - {one for one in hosts if str(one).startswith("127.")}:
        with pytest.raises(OSError):  # noqa: PT011 - refused, or no way there
            socket.create_connection((str(host), given.port), timeout=2.0).close()


def test_the_token_is_random_or_that_of_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: Given
) -> None:
    monkeypatch.setenv(TOKEN, "k" * 24)
    with shown(tmp_path / "one") as (made, address):
        assert address.endswith("/?token=" + "k" * 24)
        monkeypatch.delenv(TOKEN)
        with live_page(made, 0) as other:
            token = parse_qs(urlsplit(other).query)["token"][0]
            assert len(token) >= 32
            assert token != given.token
        for bad in ("short", "k" * 23 + "&", "\u00e9" * 24):
            monkeypatch.setitem(os.environ, TOKEN, bad)
            with pytest.raises(UsageError, match=TOKEN), live_page(made, 0):
                pass
        monkeypatch.delenv(TOKEN)
        with pytest.raises(UsageError, match="--port N"), live_page(made, given.port):
            pass


def test_the_command_says_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN, raising=False)
    lab_folder(tmp_path, REHEARSAL.format(over="tcp", faults="").replace("speed = 1000", "speed = 10"))
    words = [sys.executable, "-m", "inertialcal", "acquire", "LAB.toml", "-o", "out", "--live", "--port", "0"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as made:
        assert made.stderr is not None
        line = made.stderr.readline()
        assert line.startswith("live: http://127.0.0.1:")
        parts = urlsplit(line.removeprefix("live: ").strip())
        assert parts.port is not None
        given = Given(parts.port, parse_qs(parts.query)["token"][0])
        assert SECRETS[0] in given.send(Asked(f"/?token={given.token}", f"127.0.0.1:{given.port}").data())
        made.send_signal(signal.SIGINT)
        out, err = made.communicate(timeout=60)
    assert made.returncode == 0, err
    assert "sealed: out" in out
    assert given.token not in (tmp_path / "out" / "acquisition.json").read_text()


def test_what_cannot_be_shown_is_said_before_anything_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], given: Given
) -> None:
    path = lab_folder(tmp_path, REHEARSAL.format(over="tcp", faults=""))
    words = ("acquire", str(path), "-o", str(tmp_path / "out"), "--live")
    status, _, err = call(capsys, *words, "--port", str(given.port))
    assert status == 2
    assert f"port {given.port}: Address already in use" in err
    assert "--port N" in err
    status, _, err = call(capsys, "acquire", "--seal", str(tmp_path), "--live")
    assert status == 2
    assert "Leave out --live" in err
    monkeypatch.delitem(sys.modules, "inertialcal.lab.live.server")
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    status, _, err = call(capsys, *words)
    assert status == 2
    assert "pip install 'inertialcal[web]'" in err
    assert "uvicorn" in err
    assert not (tmp_path / "out").exists()
