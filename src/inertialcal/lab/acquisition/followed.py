"""An acquisition of another process, followed by what it writes: the whole chunks of its recording, as they come.

What is shown is what is on the disk, so it is as late as the writing to the disk (``sync``). A recording that is long
already is gone through from its beginning, in constant memory; until that is done its state is ``reading``.

Whether somebody still writes is told by the lock that the writing process holds, which the system takes away when it
dies, however it dies; where there are no locks, or another computer writes, by its sign of life: it touches the file at
each writing to the disk. A lock without a sign of life for `STALLED` is a process that hangs. A recording that is put
in the place of another is followed from its beginning.
"""

from __future__ import annotations

import json
import os
import shutil
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ...core.errors import DataError, InstrumentError
from ...core.estimate import Array
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...files.loggers.bags import Growing, Messages
from ...files.loggers.rows import ENCODING, layout_in, read_of
from ..clock import Clock
from .live import OF_COUNTS, InstrumentView, Recent, Remarks, State, StepView, Track, View
from .recorder import EVENTS, RECORDING, is_written

LOOKS = 100  # pauses of the clock between two looks at a file that has not grown
STALLED = 10.0  # [s] without a sign of life, besides the interval of writing
ENDED: tuple[State, ...] = ("done", "failed", "died")


class GoneError(Exception):
    """The recording is not there, or another one is in its place."""


@dataclass
class _Instrument:
    """What is known of an instrument."""

    track: Track
    identity: str = ""
    connected: bool = True


class Followed:
    """The acquisition that a folder holds, or will hold the recording of; `follow` reads it, in a thread of its own.

    Parameters
    ----------
    folder : path
        That ``inertialcal acquire -o`` was given.
    clock : Clock, optional
        Of this computer.

    Raises
    ------
    DataError
        ``missing_file`` where there is no recording.
    """

    def __init__(self, folder: str | Path, clock: Clock | None = None) -> None:
        self.path = Path(folder) / RECORDING
        if not self.path.is_file():
            do = f"Start it, then type this again: inertialcal acquire LAB.toml -o {folder}"
            raise DataError("no recording of an acquisition here", str(folder), do=do, code="missing_file")
        self._machine = clock or Clock()
        self._lock, self._stop = threading.RLock(), threading.Event()
        self._thread = threading.Thread(target=self.follow, name="lab follow", daemon=True)
        self._version = self._run = 0
        self._begin_anew()

    def _begin_anew(self) -> None:
        with self._lock:
            self._growing = Growing(str(self.path))
            self._state: State = "reading"
            self._why = self._title = self._status = ""
            self._speed, self._sync, self._begin = 1, 0.0, 0
            self._newest, self._utc, self._heard = 0, 0, self._machine.seconds()
            self._sampled = 0  # When the last row came [ns]
            self._alive, self._beat = 0.0, self._machine.seconds()
            self._instruments: dict[str, _Instrument] = {}
            self._remarks, self._damaged = Remarks(), 0
            self._counts: dict[tuple[str, str], int] = {}
            self._step: StepView | None = None
            self._until = 0.0
            self._ended: tuple[State, str] | None = None
            self._size = 0
            self._free: int | None = None
            self._version, self._run = self._version + 1, self._run + 1

    def __enter__(self) -> Followed:
        """Begin to follow."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self._stop.set()
        self._thread.join()

    # ---- reading ----

    def follow(self) -> None:
        """Read what comes, until it is told to end."""
        gone = False
        while not self._stop.is_set():
            try:
                with self.path.open("rb") as stream:
                    if gone:
                        gone = False
                        self._begin_anew()
                    while not self._machine.pause(self._stop, many=LOOKS):
                        self._read(stream)
            except (GoneError, FileNotFoundError):
                gone = True
                if not self.path.exists():
                    self._change("died", "the recording was removed")
            except OSError as error:
                self._change("stalled", f"the recording cannot be read: {error.strerror or error}")
            self._machine.pause(self._stop, many=LOOKS)

    def _read(self, stream: BinaryIO) -> None:
        """Take what is new of an open recording, and look at whether it is still written.

        Raises
        ------
        GoneError
            If it is no longer the one at its path.
        """
        written = is_written(stream.fileno())  # before reading: what it wrote last is there then
        about = os.fstat(stream.fileno())
        try:
            there = os.stat(self.path)
        except OSError:
            raise GoneError from None
        if (there.st_ino, there.st_dev) != (about.st_ino, about.st_dev) or about.st_size < self._size:
            raise GoneError
        self._size = about.st_size
        for part in self._growing.messages(stream):
            self._take(part)
            if self._stop.is_set():
                return
        with self._lock:
            now = self._machine.seconds()
            if about.st_mtime != self._alive:
                self._alive, self._beat = about.st_mtime, now
            with suppress(OSError):
                self._free = shutil.disk_usage(self.path.parent).free
        if self._growing.damaged > self._damaged:
            what = "chunks whose checksum is wrong: left out"
            new, self._damaged = self._growing.damaged - self._damaged, self._growing.damaged
            do = "Look at the disk: bytes were changed since they were written"
            self._remarks.add(self._utc, Remark("damaged_records", "warning", what, str(self.path), new, do))
        self._judge(written, now - self._beat)

    def _judge(self, written: bool | None, away: float) -> None:
        """Say whether it goes on, from the lock, the sign of life [s ago] and what was read."""
        still = away <= STALLED + self._machine.real(self._sync / self._speed)
        if self._growing.ended:
            self._change(*(self._ended or ("done", "")))
        elif written is False or (written is None and not still):
            do = f"to seal it: inertialcal acquire --seal {self.path.parent}"
            self._change("died", f"what is on the disk is whole; {do}")
        elif not still:
            self._change("stalled", f"no sign of life for {away:.0f} s: the process that records hangs")
        else:
            self._change("stopping" if self._ended else "running", "")

    def _change(self, state: State, why: str) -> None:
        with self._lock:
            self._version += (state, why) != (self._state, self._why)
            self._state, self._why = state, why

    def _take(self, part: Messages) -> None:
        bag = self._growing.bag
        with self._lock:
            for channel in bag.connections.values():
                if channel.encoding == ENCODING and channel.topic not in self._instruments:
                    self._instruments[channel.topic] = _Instrument(Track(layout_in(channel.schema, bag.path)))
                    self._version += 1
            for name, one in self._instruments.items():
                found = read_of(part, bag, name, one.track.layout)
                if found is not None:
                    one.track.add(found[0])
                    self._sampled = max(self._sampled, int(found[0].monotonic_ns[-1]))
                    self._came(int(found[0].monotonic_ns[-1]), int(found[0].utc_ns[-1]))
            keys = [key for key, one in bag.connections.items() if one.topic == EVENTS]
            own = np.flatnonzero(np.isin(part.keys, keys))
            for content, at in zip(part.content(own), part.first[own].tolist(), strict=True):
                utc_ns, monotonic_ns = (int.from_bytes(part.data[at - 16 + i : at - 8 + i], "little") for i in (0, 8))
                self._came(monotonic_ns, utc_ns)
                with suppress(ValueError, TypeError, KeyError):
                    said = json.loads(content)
                    EVENT_KINDS.get(said.pop("kind"), Followed._ignored)(self, said, utc_ns, monotonic_ns)
                    self._version += 1

    def _came(self, monotonic_ns: int, utc_ns: int) -> None:
        if monotonic_ns > self._newest:
            self._newest, self._utc, self._heard = monotonic_ns, utc_ns, self._machine.seconds()

    # ---- what it says of itself ----

    def _ignored(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        """Take what is not shown."""

    def _begun(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        self._title, self._speed, self._sync = str(said["title"]), int(said["speed"]), float(said["sync"])
        self._begin = monotonic_ns

    def _identified(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        self._instruments[said["instrument"]].identity = str(said["identity"])

    def _remark(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        remark = Remark(**said)
        self._remarks.add(utc_ns, remark)
        key = remark.where, remark.code
        self._counts[key] = self._counts.get(key, 0) + remark.count
        if remark.code in ("unplugged", "connected_again"):
            self._instruments[remark.where].connected = remark.code == "connected_again"

    def _stepped(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        values = tuple((str(name), float(value), str(unit)) for name, value, unit in said["values"])
        self._step = StepView(int(said["number"]), int(said["count"]), str(said["name"]), float(said["hold"]), values)
        self._until = monotonic_ns / SECOND + self._step.left

    def _status_said(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        self._status = str(said["text"])

    def _end_said(self, said: Mapping[str, Any], utc_ns: int, monotonic_ns: int) -> None:
        self._ended = ("failed" if said["state"] == "failed" else "done", str(said["why"]))

    # ---- what is shown: `live.Shown` ----

    def seconds(self) -> float:
        """Return the reading of the clock of the acquisition, as far as it is known here [s]."""
        with self._lock:
            if self._state in ENDED:  # the last samples stay in view
                return (self._sampled or self._newest) / SECOND
            return self._newest / SECOND + (self._machine.seconds() - self._heard) * self._speed

    def view(self) -> View:
        """Return all that is shown but samples."""
        with self._lock:
            now = self.seconds()
            step = None if self._step is None else replace(self._step, left=max(self._until - now, 0.0))
            elapsed = max(now - self._begin / SECOND, 0.0) if self._begin else 0.0
            utc_ns = self._utc + round((now - self._newest / SECOND) * SECOND)
            instruments = tuple(self._view(name, one) for name, one in self._instruments.items())
            return View(self._version, self._state, self._title, elapsed, utc_ns, instruments, step,
                        self._remarks.told, self._growing.at, self._free, None, self._status, self._said(),
                        self._run)  # fmt: skip

    def _said(self) -> str:
        if self._state == "reading" and self._size:
            return f"what was recorded so far is read: {self._growing.at / self._size:.0%}"
        return self._why

    def _view(self, name: str, one: _Instrument) -> InstrumentView:
        counts = {word: self._counts.get((name, code), 0) for word, code in OF_COUNTS.items()}
        track = one.track
        return InstrumentView(
            name, one.identity, track.channels, one.connected and self._state not in ENDED, track.rows,
            track.rows, track.row_rate(), **counts, intervals=track.odd_intervals()[1],
        )  # fmt: skip

    def recent(self, name: str, width: float, first: int) -> Recent:
        """Return least and most of each channel of an instrument in parts."""
        return self._track(name).recent(width, first)

    def samples(self, name: str, count: int) -> tuple[Array, Array]:
        """Return times [s], shape (n,), and values, shape (n, channels), of the last samples of an instrument."""
        return self._track(name).samples(count)

    def _track(self, name: str) -> Track:
        with self._lock:
            if name not in self._instruments:
                raise InstrumentError(f"no instrument {name!r} gives rows", code="unknown_name")
            return self._instruments[name].track


EVENT_KINDS: Mapping[str, Callable[[Followed, Mapping[str, Any], int, int], None]] = {
    "begun": Followed._begun, "identified": Followed._identified, "remark": Followed._remark,
    "step": Followed._stepped, "status": Followed._status_said, "ended": Followed._end_said,
}  # fmt: skip
