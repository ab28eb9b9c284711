"""Device: an instrument that is a link and a dialect.

What may move is held back by four things, each of which suffices. A quantity without stated limits cannot be set. A
value beyond them cannot be set. An interlock that does not answer that it is closed lets nothing be set. Any fault - a
refused value, an open interlock, a link that is lost, an answer that does not come - brings about the safe state before
it is told.

A link that is lost is opened again and again, and both is remarked; a lost stimulus stays in what it was last told, so
the acquisition makes the others safe and stops its sequence.
"""

from __future__ import annotations

import contextlib
import math
import re
import threading
from collections.abc import Iterator, Mapping

import numpy as np

from ...core.errors import DataError, InertialcalError, InstrumentError
from ...core.remarks import Remark
from ...core.units import convert
from ...files.loggers.rows import RowLayout
from ..clock import Clock, Instant
from .decoder import Counts, Decoder, number_in
from .dialect import Dialect, filled
from .links.link import Link, LinkEndedError, LinkLostError
from .protocol import Batch, Say

WAIT = 0.2  # [s] at most for what comes next, so that a stop is seen
AGAIN = 0.5  # [s] between two tries to connect again
LONGEST = 2**16  # bytes of an answer

Limits = Mapping[str, tuple[float, float]]


class Device:
    """An instrument on a link that speaks a dialect.

    Parameters
    ----------
    name : str
        As LAB.toml calls it.
    link : Link
        How its bytes come.
    dialect : Dialect
        What they mean.
    clock : Clock
        That stamps them.
    say : callable
        Takes remarks.
    limits : mapping of str to (float, float)
        Of each quantity that may be set, in its unit.
    parameters : mapping of str to str
        That its commands need.
    """

    def __init__(
        self,
        name: str,
        link: Link,
        dialect: Dialect,
        clock: Clock,
        say: Say = lambda remark: None,
        limits: Limits | None = None,
        parameters: Mapping[str, str] | None = None,
    ) -> None:
        self.name, self.link, self.dialect, self.clock, self.say = name, link, dialect, clock, say
        self.limits, self.parameters = dict(limits or {}), dict(parameters or {})
        frame = dialect.frame
        self.decoder = Decoder(dialect, link.begins_whole) if frame is not None and frame.kind != "answers" else None
        self.connected = False
        self._lock = threading.RLock()
        self._next, self._reading = threading.Lock(), threading.Lock()  # who sets is the next to have its turn

    @property
    def layout(self) -> RowLayout | None:
        """What its rows hold."""
        return self.dialect.layout

    @property
    def settable(self) -> Mapping[str, str]:
        """Unit of each quantity that can be set, by name."""
        return {name: one.unit for name, one in self.dialect.settings.items()}

    @property
    def counts(self) -> Counts:
        """What was not taken as it came."""
        return self.decoder.counts if self.decoder is not None else Counts()

    # ---- before and after ----

    def open(self) -> None:
        """Connect."""
        try:
            self.link.open()
        except LinkLostError as error:
            raise self._fault(f"cannot be reached: {error}", "unreachable") from None
        self.connected = True

    def identify(self) -> str:
        """Return who it says it is."""
        question = self.dialect.commands.identify
        return self._ask(question) if question else ""

    def configure(self) -> None:
        """Tell it its limits, then what starts it."""
        for name, (low, high) in self.limits.items():
            for command in self.dialect.settings[name].limit:
                self._tell(filled(command, {**self.parameters, "low": low, "high": high, "largest": max(-low, high)}))
        for command in self.dialect.commands.start:
            self._tell(filled(command, self.parameters))

    def close(self) -> None:
        """Tell it to stop, and disconnect."""
        with self._lock:
            if self.connected:
                with contextlib.suppress(InertialcalError):
                    for command in self.dialect.commands.stop:
                        self._tell(filled(command, self.parameters))
            self.connected = False
            self.link.close()

    # ---- rows ----

    def stream(self, stop: threading.Event) -> Iterator[Batch]:
        """Yield rows as they come."""
        if self.layout is None:
            return
        source = self._answers(stop) if self.decoder is None else self._pieces(stop)
        try:
            yield from source
        except LinkEndedError:
            return

    def _pieces(self, stop: threading.Event) -> Iterator[Batch]:
        decoder = self.decoder
        assert decoder is not None  # noqa: S101 - looked at by the caller
        while not stop.is_set():
            lost = None
            with self._next:
                self._reading.acquire()
            asked = self.clock.now()
            try:
                pieces = self.link.read(WAIT)
            except LinkLostError as error:
                lost = str(error)
            finally:
                self._reading.release()
            if lost is not None:
                if not self._connect_again(lost, stop):
                    return
                decoder.reset()
                continue
            at = self.clock.now()
            lots = [decoder.feed(piece, self.link.whole) for piece in pieces]
            if sum(map(len, lots)):
                yield Batch(np.concatenate(lots), at, asked)

    def _answers(self, stop: threading.Event) -> Iterator[Batch]:
        layout, frame = self.layout, self.dialect.frame
        assert layout is not None  # noqa: S101 - looked at by the caller
        assert frame is not None  # noqa: S101 - as the layout
        due = self.clock.seconds()
        while not stop.is_set():
            asked = self.clock.now()
            try:
                row = tuple(self._number(filled(one.ask, self.parameters)) for one in self.dialect.fields)
            except LinkLostError as error:
                if not self._connect_again(str(error), stop):
                    return
                continue
            except InstrumentError as error:
                self.say(Remark("no_answer", "warning", error.problems[0].what, where=self.name))
            else:
                yield Batch(np.array([row], layout.dtype), self.clock.now(), asked)
            due = max(due + frame.every, self.clock.seconds())
            self.clock.wait(due - self.clock.seconds(), stop)

    def _connect_again(self, why: str, stop: threading.Event) -> bool:
        """Connect again, however long it takes; return False where ``stop`` was set before."""
        begin = self.clock.seconds()
        self.connected = False
        self.say(Remark("unplugged", "error", f"the link was lost: {why}", where=self.name,
                        do="Check the cable: the link is tried again until the end"))  # fmt: skip
        while not self.clock.wait(AGAIN, stop):
            with self._lock:
                self.link.close(again=True)
                try:
                    self.link.open()
                    self.connected = True
                    for command in self.dialect.commands.start:
                        self._tell(filled(command, self.parameters))
                except (LinkLostError, InstrumentError):
                    self.connected = False
                    continue
            away = self.clock.seconds() - begin
            what = f"connected again, {away:.1f} s after the link was lost: what it sent meanwhile is missing"
            self.say(Remark("connected_again", "warning", what, where=self.name))
            return True
        return False

    # ---- quantities ----

    def check(self, quantity: str, value: float) -> str:
        """Return why a value cannot be set, and empty where it can."""
        if quantity not in self.dialect.settings:
            can = ", ".join(self.dialect.settings) or "nothing"
            return f"{self.name} has no {quantity} to set: it can set {can}"
        if quantity not in self.limits:
            return f"no limits are stated for {self.name}.{quantity}: nothing is set without"
        low, high = self.limits[quantity]
        if not (math.isfinite(value) and low <= value <= high):
            unit = self.settable[quantity]
            return f"{self.name}.{quantity} = {value:g} {unit}: beyond the limits, {low:g} to {high:g} {unit}"
        return ""

    def set(self, quantity: str, value: float) -> Instant:
        """Set a quantity within its limits, with the interlock closed; else bring about the safe state."""
        with self._next, self._reading, self._lock:  # no reading begins before it and ends after it
            at = self.clock.now()
            try:
                wrong = self.check(quantity, value)
                if wrong:
                    raise InstrumentError(wrong, code="beyond_limits")
                self._need_interlock()
                for command in self.dialect.settings[quantity].set:
                    self._tell(filled(command, {**self.parameters, "value": value}))
                self._hear()
            except InertialcalError:
                with contextlib.suppress(InertialcalError):
                    self.safe()
                raise
        return at

    def read(self, quantity: str) -> float:
        """Return a quantity as the instrument says it."""
        question = self.dialect.settings[quantity].read if quantity in self.dialect.settings else ""
        if not question:
            raise InstrumentError(f"{self.name}: {quantity} cannot be read", code="not_readable")
        try:
            return self._number(filled(question, self.parameters))
        except LinkLostError as error:
            raise self._fault(f"the link was lost: {error}", "unreachable") from None

    def safe(self) -> None:
        """Send the commands of the safe state, all of them, whatever becomes of one."""
        wrong: list[InstrumentError] = []
        with self._lock:
            for command in self.dialect.commands.safe:
                try:
                    self._tell(filled(command, self.parameters))
                except InstrumentError as error:
                    wrong.append(error)
        if wrong:
            raise wrong[0]

    def _need_interlock(self) -> None:
        interlock = self.dialect.interlock
        if interlock is None:
            return
        answer = self._ask(filled(interlock.ask, self.parameters))
        if not re.fullmatch(interlock.closed, answer):
            raise self._fault(f"the interlock is not closed: it answers {answer[:80]!r}", "interlock_open")

    # ---- words ----

    def _tell(self, command: str) -> None:
        try:
            with self._lock:
                self.link.write((command + self.dialect.terminator).encode())
                self.clock.wait(self.dialect.pause)
        except LinkLostError as error:
            raise self._fault(f"the link was lost: {error}", "unreachable") from None

    def _ask(self, question: str) -> str:
        """Return the answer to a question, without its end."""
        end = self.dialect.terminator.encode()
        with self._lock:
            self._hear()
            self._tell(question)
            found, until = b"", self.clock.seconds() + self.dialect.timeout
            try:
                while not found.rstrip(b"\r\n ") or (end not in found and not self.link.whole):
                    left = until - self.clock.seconds()
                    if left <= 0 or len(found) > LONGEST:
                        raise self._fault(f"no answer to {question!r} in {self.dialect.timeout:g} s", "no_answer")
                    found += b"".join(self.link.read(min(left, WAIT)))
            except (LinkLostError, LinkEndedError) as error:
                raise self._fault(f"the link was lost: {error}", "unreachable") from None
        answer = found.strip(b"\r\n ").partition(end)[0].decode("ascii", "replace").strip()
        self._need_no_error(answer)
        return answer

    def _hear(self) -> None:
        """Take what it said without being asked, lest it be taken for an answer; an error is a fault."""
        if self.decoder is not None:  # it sends rows
            return
        found = b""
        try:
            while piece := b"".join(self.link.read(0.0)):
                found += piece
        except (LinkLostError, LinkEndedError) as error:
            raise self._fault(f"the link was lost: {error}", "unreachable") from None
        self._need_no_error(found.decode("ascii", "replace"))

    def _need_no_error(self, said: str) -> None:
        if re.search(self.dialect.error, said):
            raise self._fault(f"it says {said.strip()[:80]!r}", "instrument_error")

    def _number(self, question: str) -> float:
        try:
            return number_in(self._ask(question), self.dialect.answer)
        except DataError as error:
            raise self._fault(error.problems[0].what, "no_number") from None

    def _fault(self, what: str, code: str) -> InstrumentError:
        return InstrumentError(f"{self.name}: {what}", code=code)


def in_unit(value: float, unit: str, wanted: str) -> float:
    """Return a value in the unit of a setting."""
    return value if not wanted or unit == wanted else float(convert(np.array([value]), unit, wanted)[0])
