"""A recording instead of an instrument: a file that is replayed, or that of a simulated rig on a pty or a socket."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from ....core.errors import InstrumentError
from ....core.recording import Recording
from ....files import read
from ....rigs import RIGS
from ...clock import Clock
from ..dialect import Dialect
from ..frames import dialect_of, due, frames, rows_of
from ..served import Served, with_faults
from .link import Link, LinkEndedError, LinkEntry, LinkKind, LinkLostError
from .network import SocketLink
from .serial import SerialLink

AT_ONCE = 4096  # samples
FRAME_FAULTS = ("late", "torn", "doubled", "lost")


class ReplayLink:
    """A recording that comes again, at the pace of the clock."""

    whole = False
    begins_whole = True

    def __init__(self, recording: Recording, clock: Clock) -> None:
        self.recording, self.clock = recording, clock
        self.dialect, self.due = dialect_of(recording), due(recording)
        self._at, self._begin = 0, 0.0

    def open(self) -> None:
        """Begin."""
        self._begin = self.clock.seconds()

    def read(self, wait: float) -> list[bytes]:
        """Return the samples that are due by now."""
        if self._at >= len(self.due):
            raise LinkEndedError
        until = self.clock.seconds() + wait
        self.clock.wait(min(self._begin + self.due[self._at], until) - self.clock.seconds())
        elapsed, stop = self.clock.seconds() - self._begin, self._at
        while stop < min(len(self.due), self._at + AT_ONCE) and self.due[stop] <= elapsed:
            stop += 1
        found = b"".join(frames(rows_of(self.recording, self.dialect, self._at, stop), self.dialect))
        self._at = stop
        return [found] if found else []

    def write(self, data: bytes) -> None:
        """Refuse: nobody is there."""
        raise LinkLostError("nothing can be sent to a recording")

    def close(self, again: bool = False) -> None:
        """End."""


class RigLink:
    """A device of a simulated rig, served on a pty or a socket, and the link to it: both begin at the first opening."""

    def __init__(self, over: str, device: Callable[[], Served], link: Callable[[str], Link]) -> None:
        self.whole, self.begins_whole = over == "udp", False
        self._make_device, self._make_link = device, link
        self._device: Served | None = None
        self._link: Link | None = None

    def open(self) -> None:
        """Start the device at the first time, and connect."""
        if self._device is None:
            self._device = self._make_device()
            self._link = self._make_link(self._device.address)
            self._link.open()
            self._device.start().ready()
        else:
            self._opened.open()

    @property
    def _opened(self) -> Link:
        if self._link is None:
            raise LinkLostError("not open")
        return self._link

    def read(self, wait: float) -> list[bytes]:
        """Return what came; when the device has sent all, there is no more."""
        over = self._device is not None and self._device.done.is_set()
        found = self._opened.read(wait)
        if not found and over:
            raise LinkEndedError
        return found

    def write(self, data: bytes) -> None:
        """Send."""
        self._opened.write(data)

    def close(self, again: bool = False) -> None:
        """Disconnect; the device stays, unless this is for good."""
        if self._link is not None:
            self._link.close()
        if self._device is not None and not again:
            self._device.close()


@lru_cache(maxsize=8)
def _of_rig(rig: str, seed: int, name: str) -> Recording:
    found = RIGS.named(rig).twin(seed).recordings
    for path, recording in found.items():
        if name in (path, Path(path).stem):
            return recording
    names = ", ".join(Path(path).stem for path in found)
    raise InstrumentError(f"rig {rig} has no recording {name!r}", do=f"There are: {names}", code="unknown_name")


@lru_cache(maxsize=8)
def _of_file(path: Path) -> Recording:
    return read(path)


def _timed(recording: Recording) -> Recording:
    if recording.stamps is None:
        raise InstrumentError("the recording has no time", recording.source.path, code="no_time")
    return recording


def _replay(entry: LinkEntry, folder: Path, clock: Clock) -> ReplayLink:
    return ReplayLink(_timed(_of_file(folder / entry.address)), clock)


def _replayed(entry: LinkEntry, folder: Path) -> Dialect:
    return dialect_of(_timed(_of_file(folder / entry.address)))


def _rig(entry: LinkEntry, folder: Path, clock: Clock) -> RigLink:
    recording = _timed(_of_rig(entry.rig, entry.seed, entry.recording))
    dialect = dialect_of(recording)
    sent = list(zip(due(recording), frames(rows_of(recording, dialect, 0, len(recording)), dialect), strict=True))
    faults = [one for one in entry.faults if one in FRAME_FAULTS]
    hello = f"{dialect.frame.comment if dialect.frame else ''}{entry.rig}\n".encode()

    def device() -> Served:
        broken = with_faults(sent, faults, entry.seed)
        return Served(broken, clock, entry.over, hello, "unplugged" in entry.faults)

    def link(address: str) -> Link:
        if entry.over == "serial":
            return SerialLink(address, entry.baud, clock)
        return SocketLink(address, entry.over == "udp", clock)

    return RigLink(entry.over, device, link)


def _of_a_rig(entry: LinkEntry, folder: Path) -> Dialect:
    return dialect_of(_timed(_of_rig(entry.rig, entry.seed, entry.recording)))


REPLAY = LinkKind("replay", ("address",), 1, _replay, _replayed, paced=True)
RIG = LinkKind("rig", ("rig", "recording", "seed", "over", "faults", "baud"), 2, _rig, _of_a_rig, paced=True)
