"""A device to rehearse on: it speaks over a pty or a socket as the real thing does, with the faults of the real thing.

Whoever reads it opens a serial port, a TCP connection or a UDP port, and cannot tell the difference; there is no way
through it to the truth. What it sends follows the clock.
"""

from __future__ import annotations

import contextlib
import os
import socket
import threading
from collections.abc import Callable, Collection, Iterable, Sequence

import numpy as np

from ...core.errors import InstrumentError
from ..clock import Clock

Timed = tuple[float, bytes]  # When it is due, since the first [s]; what is sent
SHARE = 0.02  # of the frames that a fault befalls
AWAY = 0.05  # of the whole time, for which it is unplugged
LATE = 3  # frames that one is late by
MOST_LOOKS = 2000  # at whether a reader has taken what was sent last, before a device is gone
LOOK = 0.02  # [s] of the machine between two looks at whether a question came


def with_faults(frames: Iterable[Timed], faults: Collection[str], seed: int) -> list[Timed]:
    """Return frames with faults put in: some are late, torn, doubled or lost.

    The first and the last frame stay, so that what is missing can be counted.
    """
    rng = np.random.default_rng(seed)
    sent = list(frames)
    chosen = {
        fault: set((1 + rng.choice(len(sent) - 2, max(1, round(SHARE * len(sent))), replace=False)).tolist())
        for fault in ("late", "torn", "doubled", "lost")
        if fault in faults and len(sent) > 2
    }
    found: list[tuple[float, Timed]] = []
    for i, (at, frame) in enumerate(sent):
        if i in chosen.get("lost", ()):
            continue
        kept = frame[: len(frame) // 2] if i in chosen.get("torn", ()) else frame
        place = i + LATE + 0.5 if i in chosen.get("late", ()) and i + LATE < len(sent) - 1 else float(i)
        found.append((place, (at if place == i else sent[i + LATE][0], kept)))
        if i in chosen.get("doubled", ()):
            found.append((place, (at, kept)))
    return [timed for _, timed in sorted(found, key=lambda one: one[0])]


class Served:
    """A device that sends frames and, where it is asked, answers.

    Parameters
    ----------
    frames : sequence of (float, bytes)
        When each is due [s], and what it is.
    clock : Clock
        That it follows.
    over : {"serial", "tcp", "udp"}
        How it is reached.
    hello : bytes
        What it sends first, at each connection.
    unplugged : bool
        In the middle, its link is gone for a moment: a pty and a port are closed, and come back.
    answer : callable, optional
        Question -> answer, over a pty or TCP; both without their end.
    to : (str, int), optional
        Where datagrams go.
    """

    def __init__(
        self,
        frames: Sequence[Timed],
        clock: Clock,
        over: str = "serial",
        hello: bytes = b"",
        unplugged: bool = False,
        answer: Callable[[str], str | None] | None = None,
        to: tuple[str, int] | None = None,
    ) -> None:
        self.frames, self.clock, self.over, self.hello = frames, clock, over, hello
        self.away = AWAY * (frames[-1][0] if frames else 0.0)
        self.answer, self.to = answer, to
        self._break = len(frames) // 2 if unplugged else -1
        self.stop = threading.Event()
        self.done = threading.Event()
        self._ready = threading.Event()
        self._lock = threading.Lock()
        self._fd = -1
        self._client: socket.socket | None = None
        self._server: socket.socket | None = None
        self._link_name = ""
        if over == "tcp":
            self._server = socket.create_server(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{self._server.getsockname()[1]}"
        elif over == "udp":
            if to is None:
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
                    free.bind(("127.0.0.1", 0))
                    self.to = free.getsockname()
            assert self.to is not None  # noqa: S101 - found above
            self.address = f"{self.to[0]}:{self.to[1]}"
            self._client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        else:
            self.address = self._open_pty()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> Served:
        """Begin: over TCP once somebody has connected, else when `ready` is called."""
        self._thread.start()
        return self

    def ready(self) -> None:
        """Say that somebody listens."""
        self._ready.set()

    def close(self) -> None:
        """End it."""
        self.stop.set()
        self._ready.set()
        if self._thread.is_alive():
            self._thread.join()
        self._unplug()
        for one in (self._server, self._client):
            if one is not None:
                one.close()
        if self._link_name:
            with contextlib.suppress(OSError):
                os.unlink(self._link_name)
                os.rmdir(os.path.dirname(self._link_name))
            self._link_name = ""

    # ---- the link ----

    def _open_pty(self) -> str:
        """Open a pty; its address is a link, which stays the same when it is unplugged and comes back."""
        try:
            import pty  # noqa: PLC0415 - not on Windows
            import tempfile  # noqa: PLC0415
            import tty  # noqa: PLC0415
        except ImportError:
            raise InstrumentError(
                "this system has no ptys", do='Serve it over a socket: over = "tcp"', code="no_pty"
            ) from None
        master, slave = pty.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        name = self._link_name or os.path.join(tempfile.mkdtemp(prefix="inertialcal-"), "port")
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)
        os.symlink(os.ttyname(slave), name)
        self._fd, self._slave, self._link_name = master, slave, name
        return name

    def _unplug(self) -> None:
        with self._lock:
            if self.over == "serial" and self._fd >= 0:
                for one in (self._fd, self._slave):
                    os.close(one)
                self._fd = -1
                with contextlib.suppress(OSError):
                    os.unlink(self._link_name)
            if self.over == "tcp" and self._client is not None:
                self._client.close()
                self._client = None

    def _plug(self) -> None:
        if self.over == "serial" and self._fd < 0:
            self._open_pty()
        if self.over == "tcp" and self._client is None and self._server is not None:
            self._server.settimeout(0.1)
            while not self.stop.is_set() and self._client is None:
                try:
                    self._client, _ = self._server.accept()
                    self._client.setblocking(False)
                except TimeoutError:
                    continue
                except OSError:
                    return
        self._send(self.hello)

    def _send(self, data: bytes) -> None:
        while data and not self.stop.is_set():
            try:
                if self.over == "serial":
                    data = data[os.write(self._fd, data) :]
                elif self.over == "udp":
                    assert self._client is not None  # noqa: S101 - opened above
                    assert self.to is not None  # noqa: S101 - found there
                    self._client.sendto(data, self.to)
                    return
                else:
                    assert self._client is not None  # noqa: S101 - plugged
                    data = data[self._client.send(data) :]
            except BlockingIOError:
                self.clock.pause(self.stop)  # the reader is slow: a device without flow control would lose it
            except OSError:
                return

    def _receive(self) -> bytes:
        try:
            if self.over == "serial" and self._fd >= 0:
                return os.read(self._fd, 4096)
            if self.over == "tcp" and self._client is not None:
                return self._client.recv(4096)
        except OSError:
            pass
        return b""

    # ---- what it does ----

    def _run(self) -> None:
        asked = b""
        if self.over != "tcp":
            while not self._ready.is_set() and not self.clock.pause(self.stop):
                asked = self._converse(asked)
        self._plug()
        begin, back = self.clock.seconds(), 0.0
        for i, (at, frame) in enumerate(self.frames):
            if i == self._break:
                self._unplug()
                self.clock.wait(self.away, self.stop)
                self._plug()
                back = self.clock.seconds() - begin
            if at < back:  # it goes on while nobody can hear it
                continue
            while not self.stop.is_set() and (left := begin + at - self.clock.seconds()) > 0:
                asked = self._converse(asked)
                self.clock.wait(min(left, LOOK * self.clock.speed) if self.answer else left, self.stop)
            if self.stop.is_set():
                return
            self._send(frame)
        self._drain()
        self.done.set()
        while self.answer is not None and not self.clock.pause(self.stop):
            asked = self._converse(asked)

    def _converse(self, asked: bytes = b"") -> bytes:
        """Answer questions; return what is no whole one yet."""
        if self.answer is None:
            return b""
        *lines, rest = (asked + self._receive()).replace(b"\r", b"\n").split(b"\n")
        for line in lines:
            found = self.answer(line.decode("ascii", "replace")) if line else None
            if found is not None:
                self._send(found.encode() + b"\n")
        return rest

    def _drain(self) -> None:
        """Wait until a pty was read."""
        if self.over == "serial" and self._fd >= 0:
            try:
                import fcntl  # noqa: PLC0415 - not on Windows
                import struct  # noqa: PLC0415
                import termios  # noqa: PLC0415

                for _ in range(MOST_LOOKS):
                    left = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, bytes(4)))[0]
                    if not left or self.clock.pause(self.stop):
                        return
            except (ImportError, OSError):
                return
