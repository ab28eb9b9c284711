"""TCP: a stream of bytes from a server. UDP: datagrams that come to a port of this machine."""

from __future__ import annotations

import select
import socket
from pathlib import Path

from ....core.errors import InstrumentError
from ...clock import Clock
from .link import LinkEntry, LinkKind, LinkLostError

LARGEST = 2**16  # bytes that are taken at once
AT_ONCE = 4096  # datagrams
TOGETHER = 0.02  # [s]: what comes so soon after the last piece is read together
CONNECT = 5.0  # [s]


def host_and_port(address: str) -> tuple[str, int]:
    """Return the two parts of ``HOST:PORT``.

    Raises
    ------
    InstrumentError
        ``wrong_value``.
    """
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InstrumentError(
            f"address {address!r} is not HOST:PORT", do='Write it like "192.168.1.5:5025"', code="wrong_value"
        )
    return host.strip("[]"), int(port)


class SocketLink:
    """A socket, of either kind."""

    begins_whole = False

    def __init__(self, address: str, datagrams: bool, clock: Clock) -> None:
        self.where, self.whole, self.clock = host_and_port(address), datagrams, clock
        self._socket: socket.socket | None = None
        self._last = 0.0

    def open(self) -> None:
        """Connect, or take the port."""
        try:
            if self.whole:
                family = socket.getaddrinfo(*self.where, type=socket.SOCK_DGRAM)[0][0]
                self._socket = socket.socket(family, socket.SOCK_DGRAM)
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**22)
                self._socket.bind(self.where)
            else:
                self._socket = socket.create_connection(self.where, CONNECT)
            self._socket.setblocking(False)
        except OSError as error:
            self.close()
            raise LinkLostError(error.strerror or str(error)) from None

    def read(self, wait: float) -> list[bytes]:
        """Return what came."""
        found: list[bytes] = []
        if self._socket is None:
            raise LinkLostError("not connected")
        try:
            ready, _, _ = select.select([self._socket], [], [], self.clock.real(wait))
            if not ready:
                return found
            if self.clock.seconds() - self._last < TOGETHER:
                self.clock.wait(TOGETHER)
            while len(found) < AT_ONCE:
                piece = self._socket.recv(LARGEST)
                if not piece and not self.whole:
                    if found:
                        break  # said at the next reading
                    raise LinkLostError("closed by the other side")
                found.append(piece)
        except BlockingIOError:
            pass
        except (OSError, ValueError) as error:
            raise LinkLostError(str(error)) from None
        self._last = self.clock.seconds()
        return found

    def write(self, data: bytes) -> None:
        """Send, over TCP."""
        if self._socket is None or self.whole:
            raise LinkLostError("not connected" if self._socket is None else "nothing can be sent to a UDP instrument")
        try:
            self._socket.settimeout(CONNECT)
            self._socket.sendall(data)
            self._socket.setblocking(False)
        except OSError as error:
            raise LinkLostError(str(error)) from None

    def close(self, again: bool = False) -> None:
        """Disconnect."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _tcp(entry: LinkEntry, folder: Path, clock: Clock) -> SocketLink:
    return SocketLink(entry.address, False, clock)


def _udp(entry: LinkEntry, folder: Path, clock: Clock) -> SocketLink:
    return SocketLink(entry.address, True, clock)


TCP = LinkKind("tcp", ("address",), 1, _tcp)
UDP = LinkKind("udp", ("address",), 1, _udp)
