"""Acquisition: instruments are read, what they give is recorded and shown, what moves is told step by step.

A thread for each instrument takes its rows; one writes them to the disk at a stated interval, and says then what was
acknowledged; one goes through the steps. Memory does not grow with time: what waits for the disk is bounded, and an
instrument whose rows cannot be taken waits.

Any fault of what moves ends the sequence and brings about the safe state of all that can move: an instrument that
refuses or is lost, a disk that is full, an interruption. The safe state also comes at the end.

`live` says how a running acquisition is looked at.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from ...core.errors import InertialcalError, InstrumentError, Problem, StoreError
from ...core.estimate import Array
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...files.loggers.rows import Read, RowLayout
from ..clock import Clock, Instant
from ..instruments.decoder import Counts
from ..instruments.device import Device
from ..instruments.protocol import Batch, Instrument
from .lab_file import Lab
from .live import InstrumentView, Recent, Remarks, State, StepView, Track, View
from .recorder import RECORDING, Disk, File, Recorder, event_of
from .screening import Watch

WAITING = 2**26  # bytes that may wait for the disk
LOOK = 0.2  # [s] of the clock between two looks at a bound
LOOKS = 100  # pauses of the clock between two looks at the samples
BETWEEN = 1.0  # [s] from one remark on counts of an instrument to the next
SETTLE = 5.0  # [s] from the beginning until how fast the disk fills is judged
STEP = 0.5  # [s] by which UTC is set from one writing to the disk to the next, and no less is remarked
WRITTEN_AROUND = 64  # bytes of a message around its rows


@dataclass
class _Watched:
    """An instrument, and what is known of it."""

    instrument: Instrument
    layout: RowLayout | None
    track: Track | None = None
    watch: Watch | None = None
    identity: str = ""
    told: Counts = field(default_factory=Counts)  # What was remarked already
    odd: int = 0  # Intervals that were remarked already
    looked: float = 0.0  # When counts were last looked at [s]

    @property
    def counts(self) -> Counts:
        """What was not taken as it came."""
        return self.instrument.counts if isinstance(self.instrument, Device) else Counts()

    @property
    def connected(self) -> bool:
        """Whether its link is there."""
        return self.instrument.connected if isinstance(self.instrument, Device) else True


class Conductor(Protocol):
    """What says what comes next, in place of the steps of LAB.toml."""

    def take(self, name: str, batch: Batch) -> None:
        """Take rows of an instrument; returns at once."""
        ...

    def conduct(self, acquisition: Acquisition) -> None:
        """Go through it; afterwards all ends. Raises InertialcalError, after which all is made safe."""
        ...


class Acquisition:
    """An acquisition, from its start until it is sealed.

    Parameters
    ----------
    lab : Lab
        What LAB.toml says.
    folder : path
        New or empty; it is made.
    clock : Clock, optional
        That all keep to; by default that of the lab.
    instruments : sequence of Instrument, optional
        In place of those that LAB.toml describes, under the same names.
    disk : callable, optional
        Makes the file that is written.
    free : callable, optional
        Returns how much of a disk is free [byte].
    conductor : Conductor, optional
        In place of the steps of LAB.toml.
    """

    def __init__(
        self,
        lab: Lab,
        folder: str | Path,
        clock: Clock | None = None,
        instruments: Sequence[Instrument] | None = None,
        disk: Callable[[Path], Disk] = File,
        free: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        conductor: Conductor | None = None,
    ) -> None:
        self.lab, self.folder, self.clock = lab, Path(folder), clock or lab.clock()
        self._disk, self._free, self._conductor = disk, free, conductor
        self._lock = threading.RLock()
        self._room = threading.Condition(self._lock)
        self._stop, self._finished = threading.Event(), threading.Event()
        self._state: State = "ready"
        self._version = 0
        self._remarks, self._status = Remarks(), ""
        self._queue: list[tuple[str, Batch]] = []
        self._events: list[tuple[Instant, str, Mapping[str, object]]] = []
        self._waiting = 0
        self._begin = self.clock.now()
        self._apart = 0  # UTC less the monotonic reading [ns]
        self._step: StepView | None = None
        self._until = 0.0
        self._set_last: dict[str, tuple[str, float, str]] = {}
        self._free_bytes: int | None = None
        self._full_in: float | None = None
        self._warned = np.inf
        self._errors: list[InertialcalError] = []
        self._recorder: Recorder | None = None
        devices = instruments if instruments is not None else lab.devices(self.clock, self.say)
        self._watched = {one.name: self._watch(one) for one in devices}
        self._threads: list[threading.Thread] = []
        self._listening = 0

    def _watch(self, one: Instrument) -> _Watched:
        said = self.lab.file.instruments[one.name]
        if one.layout is None:
            return _Watched(one, None)
        layout = replace(one.layout, interval=said.interval, clock_within=said.clock_within)
        track = Track(layout)
        return _Watched(one, layout, track, Watch(one.name, track, self.clock))

    # ---- from outside ----

    def start(self) -> None:
        """Connect and configure all, and begin.

        Raises
        ------
        InstrumentError
            With all that cannot be reached; nothing moves then, and nothing is written.
        StoreError
            ``not_empty``, ``not_written``.
        """
        self._make_folder()
        try:
            self._connect()
            layouts = {name: one.layout for name, one in self._watched.items() if one.layout is not None}
            about = {"LAB.toml": self.lab.text, "sha256": self.lab.sha256, **_texts(self.lab.dialect_texts)}
            self._recorder = Recorder(self._disk(self.folder / RECORDING), layouts, about)
            self._recorder.commit()
        except OSError as error:
            self._close_all()
            what = f"cannot be written: {error.strerror or error}"
            raise StoreError(what, str(self.folder / RECORDING), code="not_written") from None
        except InertialcalError:
            self._close_all()
            raise
        self._begin = self.clock.now()
        self._apart = self._begin.utc_ns - self._begin.monotonic_ns
        entry = self.lab.file.lab
        self._event("begun", {"title": entry.title, "speed": self.clock.speed, "sync": entry.sync})
        self._change("running")
        for name, one in self._watched.items():
            if one.identity:
                self._event("identified", {"instrument": name, "identity": one.identity})
        listeners = [threading.Thread(target=self._listen, args=(one,), name=f"lab {name}", daemon=True)
                     for name, one in self._watched.items()]  # fmt: skip
        self._listening = len(listeners)
        self._threads = [*listeners, threading.Thread(target=self._sequence, name="lab steps", daemon=True)]
        for thread in self._threads:
            thread.start()
        self._looking = threading.Thread(target=self._look, name="lab samples", daemon=True)
        self._looking.start()
        self._recording = threading.Thread(target=self._record, name="lab disk", daemon=True)
        self._recording.start()

    def stop(self) -> None:
        """Ask it to end; returns at once."""
        self._stop.set()

    def wait(self, seconds: float | None = None) -> bool:
        """Wait until all is written, so many seconds of the clock at most; return whether it is.

        Raises
        ------
        InertialcalError
            What ended it, if that was a fault.
        """
        self._finished.wait(None if seconds is None else self.clock.real(seconds))
        if self._finished.is_set() and self._errors:
            raise self._errors[0]
        return self._finished.is_set()

    @property
    def stopping(self) -> threading.Event:
        """Set as soon as it is to end."""
        return self._stop

    def set(self, name: str, quantity: str, value: float) -> Instant:
        """Set a quantity of an instrument, in its unit; what is asked for from the returned moment on came after it.

        Raises
        ------
        InstrumentError
            If it cannot be set, or an instrument that can move is not connected; the one that was to be set is safe.
        """
        self.need_links()
        one = self._watched[name].instrument
        at = one.set(quantity, value)
        self._event("set", {"instrument": name, "quantity": quantity, "value": value})
        self._set_last[f"{name}.{quantity}"] = (f"{name}.{quantity}", value, one.settable[quantity])
        return at

    def show(self, number: int, count: int, name: str, seconds: float) -> None:
        """Show a step, and the time that it takes yet [s]."""
        with self._lock:
            self._until = self.clock.seconds() + seconds
            self._step = StepView(number, count, name, seconds, tuple(self._set_last.values()))
            self._event("step", {
                "number": number, "count": count, "name": name, "hold": seconds, "values": self._step.values,
            })  # fmt: skip

    def connected(self, name: str) -> bool:
        """Whether the link of an instrument is there."""
        return self._watched[name].connected

    def need_links(self) -> None:
        """Refuse to go on while an instrument that can move is not connected.

        Raises
        ------
        InstrumentError
            ``unreachable``.
        """
        for name, one in self._watched.items():
            if one.instrument.settable and not one.connected:
                raise InstrumentError(f"{name} is not connected", code="unreachable")

    def say(self, remark: Remark) -> None:
        """Take a remark: it is shown, and recorded."""
        at = self.clock.now()
        with self._lock:
            self._remarks.add(at.utc_ns, remark)
            self._version += 1
            self._events.append((at, "remark", event_of(remark)))

    def publish(self, status: str) -> None:
        """Take what whoever leads the test says of where it is: it is shown, and recorded."""
        with self._lock:
            if status != self._status:
                self._status = status
                self._event("status", {"text": status})

    def seconds(self) -> float:
        """Return the reading of the clock that stamps the samples [s]."""
        return self.clock.seconds()

    def view(self) -> View:
        """Return all that is shown."""
        now = self.clock.now()
        with self._lock:
            recorder = self._recorder
            acknowledged = {} if recorder is None else recorder.acknowledged
            step = self._step
            if step is not None:
                step = replace(step, left=max(self._until - now.monotonic_ns / SECOND, 0.0))
            return View(
                self._version, self._state, self.lab.file.lab.title, self._elapsed(now), now.utc_ns,
                tuple(_view(one, acknowledged.get(name, 0)) for name, one in self._watched.items()),
                step, self._remarks.told, 0 if recorder is None else recorder.written,
                self._free_bytes, self._full_in, self._status,
                self._errors[0].problems[0].what if self._errors else "",
            )  # fmt: skip

    def instrument(self, name: str) -> Instrument:
        """Return an instrument."""
        return self._watched[name].instrument

    def recent(self, name: str, width: float, first: int) -> Recent:
        """Return least and most of each channel of an instrument in parts: `live.Shown`."""
        return self._track(name).recent(width, first)

    def samples(self, name: str, count: int) -> tuple[Array, Array]:
        """Return times [s], shape (n,), and values, shape (n, channels), of the last samples of an instrument."""
        return self._track(name).samples(count)

    def since(self, name: str, first: int) -> tuple[int, Array, Array]:
        """Return how many samples of an instrument ever came; times and values of those from number ``first`` on."""
        begin, seconds, values = self._track(name).from_sample(first)
        return begin + len(seconds), seconds, values

    def _track(self, name: str) -> Track:
        track = self._watched[name].track if name in self._watched else None
        if track is None:
            have = ", ".join(one for one, watched in self._watched.items() if watched.track is not None)
            raise InstrumentError(f"no instrument {name!r} gives rows", do=f"There are: {have}", code="unknown_name")
        return track

    # ---- beginning and end ----

    def _make_folder(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if any(self.folder.iterdir()):
                unfinished = (self.folder / RECORDING).exists()
                do = "Name a folder that is new or empty"
                do += f"; to seal what is there: inertialcal acquire --seal {self.folder}" if unfinished else ""
                raise StoreError("the folder is not empty", str(self.folder), do=do, code="not_empty")
        except OSError as error:
            raise StoreError(f"cannot be made: {error.strerror}", str(self.folder), code="not_written") from None

    def _connect(self) -> None:
        """Connect all and ask who they are; only then is any of them configured."""
        problems: list[Problem] = []
        for name, one in self._watched.items():
            try:
                one.instrument.open()
                one.identity = one.instrument.identify()
            except InstrumentError as error:
                where = self.lab.place("instruments", name)
                problems += [replace(problem, where=where) for problem in error.problems]
        if problems:
            raise InstrumentError(problems)
        for name, one in self._watched.items():
            try:
                one.instrument.configure()
            except InstrumentError as error:
                self._make_safe()
                where = self.lab.place("instruments", name)
                raise InstrumentError([replace(problem, where=where) for problem in error.problems]) from None

    def _close_all(self) -> None:
        for one in self._watched.values():
            one.instrument.close()

    def _make_safe(self) -> None:
        """Bring about the safe state of all that can move; what cannot be made safe is remarked."""
        for name, one in self._watched.items():
            if not one.instrument.settable:
                continue
            try:
                one.instrument.safe()
                self._event("safe", {"instrument": name})
            except InstrumentError as error:
                what = f"the safe state could not be brought about: {error.problems[0].what}"
                self.say(Remark("not_safe", "error", what, where=name, do="Look at it, and make it safe by hand"))

    def _change(self, state: State) -> None:
        with self._lock:
            self._state = state
            self._version += 1

    def _elapsed(self, now: Instant) -> float:
        return (now.monotonic_ns - self._begin.monotonic_ns) / SECOND

    def _event(self, kind: str, content: Mapping[str, object]) -> None:
        with self._lock:
            self._events.append((self.clock.now(), kind, content))
            self._version += 1

    def _fail(self, error: InertialcalError) -> None:
        with self._lock:
            self._errors.append(error)
        self._stop.set()

    # ---- instruments ----

    def _listen(self, one: _Watched) -> None:
        """Take what an instrument gives, until there is no more."""
        try:
            for batch in one.instrument.stream(self._stop):
                self._take(one, batch)
        except InertialcalError as error:
            self.say(Remark("instrument_failed", "error", error.problems[0].what, where=one.instrument.name))
            self._fail(error)
        finally:
            self._remark_counts(one)
            with self._lock:
                self._listening -= one.layout is not None

    def _take(self, one: _Watched, batch: Batch) -> None:
        name, track = one.instrument.name, one.track
        assert track is not None  # noqa: S101 - it has given rows
        size = batch.rows.nbytes + WRITTEN_AROUND
        with self._room:
            while self._waiting + size > WAITING and self._waiting and not self._finished.is_set():
                self._room.wait(self.clock.real(LOOK))
            self._queue.append((name, batch))
            self._waiting += size
        if self._conductor is not None:
            self._conductor.take(name, batch)
        at = batch.at
        track.add(Read(batch.rows, np.array([len(batch.rows) - 1]), np.array([at.utc_ns]), np.array([at.monotonic_ns])))
        if at.monotonic_ns / SECOND - one.looked >= BETWEEN:
            one.looked = at.monotonic_ns / SECOND
            self._remark_counts(one)

    def _look(self) -> None:
        """Look the samples through, whether or not somebody watches."""
        watches = [one.watch for one in self._watched.values() if one.watch is not None]
        while not self.clock.pause(self._stop, many=LOOKS):
            for one in watches:
                for remark in one.look():
                    self.say(remark)
        for thread in self._threads:
            thread.join()
        for one in watches:
            for remark in one.look(last=True):
                self.say(remark)

    def _remark_counts(self, one: _Watched) -> None:
        """Remark what was not taken as it came, each kind once in a while with its new count."""
        now, name = replace(one.counts), one.instrument.name
        for code, what, new in (
            ("damaged_rows", "rows that were not whole: left out", now.damaged - one.told.damaged),
            ("doubled_rows", "rows that came twice: taken once", now.doubled - one.told.doubled),
            ("late_rows", "rows that came after later ones: left out", now.late - one.told.late),
            ("lost_rows", "rows that are missing by the counter", now.lost - one.told.lost),
            ("began_anew", "the instrument began anew", now.restarted - one.told.restarted),
        ):
            if new > 0:
                self.say(Remark(code, "warning", what, where=name, count=new))
        one.told = now
        odd, which = (0, "") if one.track is None else one.track.odd_intervals()
        if odd > one.odd:
            what = f"not saved as often as stated: {which}"
            self.say(Remark("save_intervals", "warning", what, where=name, count=odd))
        one.odd = odd

    # ---- the disk ----

    def _record(self) -> None:
        """Write to the disk at the stated interval until all have ended."""
        entry = self.lab.file.lab
        due = self.clock.seconds()
        try:
            while not self._ends():
                due = max(due + entry.sync, self.clock.seconds())
                self.clock.wait(due - self.clock.seconds(), self._stop)
                self._commit()
                self._watch_disk()
                self._watch_clock()
        except OSError as error:
            self._disk_failed(error)
        self._stop.set()
        self._change("stopping")
        for thread in (*self._threads, self._looking):
            thread.join()
        self._make_safe()
        self._close_all()
        try:
            if not self._errors or not isinstance(self._errors[0], StoreError):
                why = self._errors[0].problems[0].what if self._errors else ""
                self._event("ended", {"state": "failed" if self._errors else "done", "why": why})
                self._commit()
                self._need_recorder().finish()
        except OSError as error:
            self._disk_failed(error)
        self._need_recorder().disk.close()
        self._change("failed" if self._errors else "done")
        self._finished.set()
        with self._room:
            self._room.notify_all()

    def _ends(self) -> bool:
        duration = self.lab.file.lab.duration
        over = duration is not None and self._elapsed(self.clock.now()) >= duration
        with self._lock:
            nobody = not any(thread.is_alive() for thread in self._threads)
            no_more = self._listening == self._silent() and not self.lab.steps and self._conductor is None
        return self._stop.is_set() or over or nobody or no_more

    def _silent(self) -> int:
        return sum(one.layout is None for one in self._watched.values())

    def _need_recorder(self) -> Recorder:
        assert self._recorder is not None  # noqa: S101 - made at the start
        return self._recorder

    def _commit(self) -> None:
        recorder = self._need_recorder()
        with self._room:
            batches, self._queue = self._queue, []
            events, self._events = self._events, []
            self._waiting = 0
            self._room.notify_all()
        for name, batch in batches:
            recorder.add(name, batch)
        for at, kind, content in events:
            recorder.event(at, kind, content)
        recorder.commit()

    def _watch_disk(self) -> None:
        """Say before it happens that the disk will be full; end before it is."""
        entry, elapsed = self.lab.file.lab, self._elapsed(self.clock.now())
        with suppress(OSError):
            os.utime(self.folder / RECORDING)  # a sign of life, for who follows it (`followed`)
        try:
            free = self._free(self.folder)
        except OSError:
            return
        written = self._need_recorder().written
        left = max(free - self.lab.keep_free, 0)
        full_in = left * elapsed / written if written and elapsed > SETTLE else None
        with self._lock:
            self._free_bytes, self._full_in = free, full_in
        if left == 0:
            what = f"the disk is full: {free / 1e6:,.0f} MB are free, {entry.keep_free} are to stay free"
            raise OSError(28, what)
        needed = entry.warn_before if entry.duration is None else max(entry.duration - elapsed, 0.0)
        if full_in is not None and full_in < max(needed, 0.0) and full_in < 0.5 * self._warned:
            self._warned = full_in
            what = f"the disk will be full in {_long(full_in)}: {free / 1e6:,.0f} MB are free"
            self.say(
                Remark("disk_filling", "warning", what, where=str(self.folder), do="Free some space: recording goes on")
            )

    def _watch_clock(self) -> None:
        """Say that UTC of this computer was set: times of what is recorded go on by the clock that is never set."""
        now = self.clock.now()
        apart = now.utc_ns - now.monotonic_ns
        step, self._apart = (apart - self._apart) / SECOND, apart
        least = STEP * self.clock.speed  # of the machine, whose readings are a moment apart
        if abs(step) > least:
            word = "back" if step < 0 else "forward"
            what = f"the clock of this computer was set {word} by {abs(step):.1f} s: times go on as if it had not been"
            self.say(Remark("clock_set", "warning", what, do="Compare times with those of others by its first setting"))

    def _disk_failed(self, error: OSError) -> None:
        what = error.strerror or str(error)
        done = self._need_recorder().acknowledged
        kept = ", ".join(f"{count:,} of {name}" for name, count in done.items())
        self.say(Remark("not_written", "error", what, where=str(self.folder)))
        why = f"rows that are safe on the disk: {kept}"
        do = f"Make room, then type: inertialcal acquire --seal {self.folder}"
        self._fail(StoreError(what, str(self.folder / RECORDING), why, do, "not_written"))

    # ---- what moves ----

    def _sequence(self) -> None:
        """Go through the steps; afterwards end, where nothing else says when."""
        if not self.lab.steps and self._conductor is None:
            return
        try:
            if self._conductor is not None:
                self._conductor.conduct(self)
            elif self._stopped_in_steps():
                return
        except Exception as error:  # whatever it was: what moves must not go on
            own = error if isinstance(error, InertialcalError) else InstrumentError(repr(error), code="internal")
            do = "All that moves was brought to its safe state"
            self.say(Remark("sequence_ended", "error", own.problems[0].what, do=do))
            self._make_safe()
            self._fail(own)
            return
        if self.lab.file.lab.duration is None:
            self._stop.set()

    def _stopped_in_steps(self) -> bool:
        """Go through the steps of LAB.toml; return whether it was stopped."""
        for number, step in enumerate(self.lab.steps, 1):
            for name, quantity, value in step.values:
                self.set(name, quantity, value)
            self.show(number, len(self.lab.steps), step.name, step.hold)
            for left in self._hold(self._until):
                if self.clock.wait(left, self._stop):
                    return True
                self.need_links()
        return False

    def _hold(self, until: float) -> Iterator[float]:
        while (left := until - self.clock.seconds()) > 0:
            yield min(left, LOOK)


def _view(one: _Watched, acknowledged: int) -> InstrumentView:
    counts, track = one.counts, one.track
    return InstrumentView(
        one.instrument.name, one.identity, track.channels if track else (), one.connected, track.rows if track else 0,
        acknowledged, track.row_rate() if track else None, counts.damaged, counts.doubled, counts.late,
        counts.lost, track.odd_intervals()[1] if track else "",
    )  # fmt: skip


def _texts(texts: Mapping[str, str]) -> dict[str, str]:
    return {f"dialect of {name}": text for name, text in texts.items()}


def _long(seconds: float) -> str:
    """Return a time in words: ``"2.5 h"``."""
    for size, unit in ((86400.0, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.0f} s"
