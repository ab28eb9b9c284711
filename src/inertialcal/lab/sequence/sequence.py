"""A sequence: steps one after another, each PASS once its record was stored and read again.

What a record holds follows from the rows that came after the step was set, by the clock of the instrument, and from
nothing else: neither when the computer was slow nor when it stopped changes it.

A recording is made in one go. When a sequence was cut off, or a step of it has failed, the steps of a recording that is
not complete are done anew; whatever was complete stays, as long as its files are as they were stored. Before that all
is set that was set before, and the operator is asked again for what was asked last.

Every way in which a step can end has a name: ``unreachable``, ``interlock_open``, ``instrument_error`` and the others
of an instrument that moves; ``not_stable``, ``left_stable``, ``u_not_reached``, ``no_rows``, ``unplugged``,
``clock_back``; ``not_stored``, ``not_read_again``; ``operator_stop``. Each but a pause brings about the safe state,
once the tries are used up.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.errors import InertialcalError, InstrumentError, StoreError
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.times import instant_text
from ...core.units import convert
from ...files.write.atomic import write_new
from ..acquisition.acquisition import Acquisition
from ..acquisition.lab_file import Lab
from ..clock import Clock
from ..instruments.protocol import Batch
from . import conditions
from .as_run import AsRun, Log, Status, time_text
from .operator import Operator
from .steps import Record, SequenceStep, Stable
from .store import Stored, is_there, store
from .taken import Since, Taken

LAB_FILE, ACQUIRED = "LAB.toml", "acquired"
LOOK = 0.05  # [s] of the machine between two looks at what else may have happened
SHORTEST_SILENCE = 2.0  # [s] of the machine, however fast the clock
LOOKS = 20  # at whether it is steady in the time for which it has to be, and as many to double a record
WINDOW = 4.0  # of the time for which something has to be steady, that is judged
FEWEST = 256  # rows that are judged at least, where there are so many
DONE = ("operator_stop", "not_written")  # ends after which a step is not tried again


class _Paused(Exception):  # noqa: N818 - no error
    """The operator wants a pause."""


class _Ended(Exception):  # noqa: N818 - no error
    """All is to end."""


class Sequence:
    """A sequence in a folder, new or begun.

    Parameters
    ----------
    lab : Lab
        With the steps.
    folder : path
        Of the sequence.
    operator : Operator
        Who is asked.

    Raises
    ------
    StoreError
        ``not_written``, ``other_sequence``, ``damaged_file``.
    """

    def __init__(self, lab: Lab, folder: Path, operator: Operator) -> None:
        self.lab, self.folder, self.operator = lab, folder, operator
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not (folder / LAB_FILE).exists():
                write_new(folder / LAB_FILE, lab.text.encode())
        except OSError as error:
            raise StoreError(f"cannot be made: {error.strerror}", str(folder), code="not_written") from None
        self.log = Log(folder, lab.sha256)
        layouts = {
            name: replace(one.layout, interval=lab.file.instruments[name].interval)
            for name, one in lab.dialects.items() if one.layout is not None
        }  # fmt: skip
        self._taken = Taken(layouts)
        self._acquisition: Acquisition | None = None
        self._values: dict[tuple[str, str], float] = {}  # that hold at a step
        self._restored = False  # whether all that holds is set
        self.passed = self._passed()

    # ---- what is done ----

    def _passed(self) -> set[int]:
        """Return the steps that are PASS and stay so: of recordings that are complete, with their files."""
        last = self.log.last()
        good = set()
        for step in self.lab.sequence:
            row = last.get(step.number)
            if row is None or row.status != "PASS":
                continue
            if step.record is None or is_there(self.folder, row.file, row.sha256):
                good.add(step.number)
        whole: dict[str, bool] = {}
        for step in self.lab.sequence:
            if step.record is not None:
                whole[step.recording] = whole.get(step.recording, True) and step.number in good
        return {one.number for one in self.lab.sequence if one.number in good and whole.get(one.recording, True)}

    @property
    def complete(self) -> bool:
        """Whether every step is PASS."""
        return len(self.passed) == len(self.lab.sequence)

    @property
    def records(self) -> Mapping[int, Stored]:
        """Record of each step that is PASS and has one."""
        last = self.log.last()
        return {number: Stored(last[number].file, last[number].sha256) for number in self.passed if last[number].file}

    def acquired(self) -> Path:
        """Return a new folder for what is acquired."""
        numbers = [int(one.name) for one in (self.folder / ACQUIRED).glob("*") if one.name.isdecimal()]
        return self.folder / ACQUIRED / f"{max(numbers, default=0) + 1:03d}"

    # ---- Conductor ----

    def take(self, name: str, batch: Batch) -> None:
        """Take rows."""
        self._taken.take(name, batch)

    def conduct(self, acquisition: Acquisition) -> None:
        """Go through the steps that are not done.

        Raises
        ------
        InertialcalError
            How a step ended that failed in all tries, or the log could not be written.
        """
        self._acquisition = acquisition
        kept, asked = set(self.passed), ""
        try:
            for step in self.lab.sequence:
                if step.number in kept:
                    asked, self._restored = step.prompt or asked, False
                    self._values |= {(name, quantity): value for name, quantity, value in step.values}
                    continue
                self._redo(step)
                if asked and not step.prompt and not self.operator.ask(asked, acquisition.stopping):
                    raise _Ended
                asked = ""
                self._until_passed(step)
        except _Ended:
            return

    def _redo(self, step: SequenceStep) -> None:
        """Say of a step that was PASS that it is done anew."""
        row = self.log.last().get(step.number)
        if row is not None and row.status == "PASS":
            self._note(step, row.attempt, "REDONE", "resumed", "its recording was not complete, or is not as it was")

    def _until_passed(self, step: SequenceStep) -> None:
        tries, entry = 0, self.lab.file.sequence
        most = 1 if entry is None else entry.tries
        before = dict(self._values)
        while True:
            attempt = self.log.attempts(step.number) + 1
            self._values = dict(before)
            try:
                self._do(step, attempt)
            except _Paused:
                self._note(step, attempt, "PAUSED", "operator_pause", "the step is done anew")
                if not self.operator.wait_to_go_on(self._running.stopping):
                    raise _Ended from None
                continue
            except _Ended:
                self._note(step, attempt, "FAILED", "interrupted", "all was to end")
                raise
            except InertialcalError as error:
                own, self._restored = error.problems[0], False
                self._note(step, attempt, "FAILED", own.code, own.what)
                tries += 1
                if tries >= most or own.code in DONE:
                    what = f"step {step.number}, {step.name}: {own.what}"
                    do = f"{self.log.path} says what was done; the sequence can be resumed"
                    raise InstrumentError(what, own.where, own.why, do, own.code or "step_failed") from None
                self._running.say(Remark("step_tried_again", "warning", own.what, where=step.name))
                continue
            self.passed.add(step.number)
            return

    def _note(self, step: SequenceStep, attempt: int, status: Status, code: str = "", what: str = "") -> None:
        self.log.add(self._row(step, attempt, status, code=code, what=what))

    def _row(self, step: SequenceStep, attempt: int, status: Status, **more: object) -> AsRun:
        texts = [f"{name}.{quantity} = {value:g} {self._unit(name, quantity)}".rstrip()
                 for (name, quantity), value in self._values.items()]  # fmt: skip
        ended = instant_text(self._running.clock.now().utc_ns)
        given: dict[str, object] = {
            "ended": ended, "step": step.number, "name": step.name, "recording": step.recording if step.record else "",
            "attempt": attempt, "status": status, "set": "; ".join(texts),
        }  # fmt: skip
        return AsRun(**{**given, **more})  # type: ignore[arg-type]

    def _unit(self, name: str, quantity: str) -> str:
        return self.lab.dialects[name].settings[quantity].unit

    @property
    def _running(self) -> Acquisition:
        assert self._acquisition is not None  # noqa: S101 - conducted
        return self._acquisition

    @property
    def _clock(self) -> Clock:
        return self._running.clock

    # ---- a step ----

    def _do(self, step: SequenceStep, attempt: int) -> None:
        """Do a step once.

        Raises
        ------
        InertialcalError
            How it ended, if it is not PASS.
        """
        running = self._running
        self._show(step, "asks" if step.prompt else "sets")
        self._look()
        if step.prompt and not self.operator.ask(step.prompt, running.stopping):
            raise _Ended
        self._restore(step)
        since = self._clock.now()
        for name, quantity, value in step.values:
            self._values[name, quantity] = value
            since = running.set(name, quantity, value)
        if step.hold > 0.0:
            self._show(step, "holds", step.hold)
            until = self._clock.seconds() + step.hold
            while (left := until - self._clock.seconds()) > 0.0:
                running.stopping.wait(min(self._clock.real(left), LOOK))
                self._look()
            since = self._clock.now()
        self._taken.begin(since.monotonic_ns)
        first: dict[str, int] = {}
        if step.stable is not None:
            self._show(step, "waits until it is steady", step.stable.limit)
            first = self._await(step.stable)
        if step.record is None:
            self._note(step, attempt, "PASS")
            return
        self._show(step, "records", step.record.most)
        kept = self._record(step.stable, step.record, first)
        u = ""
        if step.record.u is not None:
            found, _ = conditions.uncertainty(kept.values(step.record.channels), kept.time_ns)
            u = f"{float(np.max(found)):.6g}"
        stored = store(self.folder, f"{step.number:04d}_{attempt}", kept.recording())
        ends = [time_text(int(one), kept.utc) for one in (kept.time_ns[0], kept.time_ns[-1])]
        self.log.add(self._row(step, attempt, "PASS", start=ends[0], stop=ends[1], rows=len(kept), u=u,
                               file=stored.file, sha256=stored.sha256))  # fmt: skip

    def _restore(self, step: SequenceStep) -> None:
        """Set again what holds at the first step that is done, or after a failed one: all may be in its safe state."""
        if self._restored:
            return
        own = {(name, quantity) for name, quantity, _ in step.values}
        for (name, quantity), value in self._values.items():
            if (name, quantity) not in own:
                self._running.set(name, quantity, value)
        self._restored = True

    def _show(self, step: SequenceStep, doing: str, seconds: float = 0.0) -> None:
        self._running.show(step.number, len(self.lab.sequence), f"{step.name}: {doing}", seconds)

    def _look(self) -> None:
        """See whether to go on."""
        if self._running.stopping.is_set():
            raise _Ended
        self.operator.check()
        if self.operator.paused:
            raise _Paused
        self._running.need_links()

    def _rows(self, name: str) -> Iterator[Since]:
        """Yield what came of an instrument each time that there is more.

        Raises
        ------
        InstrumentError
            ``unplugged``, ``no_rows``, and those of what moves.
        """
        entry = self.lab.file.sequence
        silence = 60.0 if entry is None else entry.silence
        known, count, machine = 0, 0, Clock()
        since, since_machine = self._clock.seconds(), machine.seconds()
        while True:
            self._look()
            if not self._running.connected(name):
                raise InstrumentError(f"{name} is not connected", code="unplugged")
            known = self._taken.wait(known, LOOK)
            found = self._taken.of(name)
            if len(found) > count:
                yield found
                count, since, since_machine = len(found), self._clock.seconds(), machine.seconds()
            elif self._clock.seconds() - since > silence and machine.seconds() - since_machine > SHORTEST_SILENCE:
                raise InstrumentError(f"{name} sent nothing for {silence:g} s", code="no_rows")

    def _target(self, stable: Stable) -> float | None:
        """Return the value that a channel has to have, in its unit."""
        if stable.follows is None:
            return stable.at
        value = self._values.get(stable.follows)
        if value is None:
            what = f"{'.'.join(stable.follows)} was not set: nothing can follow it"
            raise InstrumentError(what, code="not_stable")
        layout = self.lab.dialects[stable.instrument].layout
        unit = next((one.unit for one in layout.channels if one.name == stable.channel), "") if layout else ""
        own = self._unit(*stable.follows)
        return float(convert(np.array([value]), own, unit)[0]) if own and unit and own != unit else value

    def _await(self, stable: Stable) -> dict[str, int]:
        """Wait until it is steady; return how many rows of each instrument had come by then.

        Raises
        ------
        InstrumentError
            ``not_stable``.
        """
        target, judged, step = self._target(stable), 0, stable.lasting / LOOKS * SECOND
        for found in self._rows(stable.instrument):
            elapsed = found.time_ns - found.time_ns[0]
            turn = np.floor_divide(elapsed, step) if step else np.arange(len(found))
            stops = np.flatnonzero(np.diff(turn, prepend=-1)) + 1  # the same ones however the rows came together
            for stop in stops[stops > judged].tolist():
                if self._steady(stable, target, found.part(0, stop)):
                    return {name: len(self._taken.of(name)) for name in self._taken.names} | {stable.instrument: stop}
            judged = len(found)
            if elapsed[-1] > stable.limit * SECOND:
                what = f"not steady within {stable.limit:g} s"
                if stable.channel:
                    last = found.values((stable.channel,))[-1, 0]
                    what += f": {stable.channel} is {last:g}" + ("" if target is None else f", {target:g} is wanted")
                raise InstrumentError(what, code="not_stable")
        raise AssertionError  # pragma: no cover - rows come, or an error does

    def _steady(self, stable: Stable, target: float | None, found: Since) -> bool:
        span = found.time_ns[-1] - WINDOW * stable.lasting * SECOND
        part = found.part(min(int(np.searchsorted(found.time_ns, span)), max(len(found) - FEWEST, 0)), len(found))
        if stable.still:
            return conditions.at_rest(part.values(stable.still), part.time_ns, stable.lasting)
        return conditions.held(
            part.values((stable.channel,))[:, 0], part.time_ns, target, stable.within, stable.lasting
        )

    def _record(self, stable: Stable | None, record: Record, first: Mapping[str, int]) -> Since:
        """Return the rows of a record, as long as is needed.

        Raises
        ------
        InstrumentError
            ``left_stable``, ``u_not_reached``.
        """
        target, judged = None if stable is None else self._target(stable), 0
        for found in self._rows(record.instrument):
            own = found.part(first.get(record.instrument, 0), len(found))
            if not len(own):
                continue
            elapsed = own.time_ns - own.time_ns[0]
            stop = max(int(np.searchsorted(elapsed, round(record.least * SECOND))) + 1, judged)
            while stop <= len(own):
                part = own.part(0, stop)
                if record.u is None or conditions.known_well(part.values(record.channels), part.time_ns, record.u):
                    self._check_kept(stable, target, record, part, first)
                    return part
                if elapsed[stop - 1] >= round(record.most * SECOND):
                    _, half = conditions.uncertainty(part.values(record.channels), part.time_ns)
                    found_u = float(np.max(half)) / conditions.WIDE
                    what = (
                        f"u is {found_u:.3g}" if np.isfinite(found_u) else "too few samples are independent to tell u"
                    )
                    what = f"after {record.most:g} s {what}, {record.u:g} is wanted"
                    raise InstrumentError(what, code="u_not_reached")
                stop += max(stop // LOOKS, 1)  # the same ones however the rows came together
            judged = stop if elapsed[-1] >= round(record.least * SECOND) else 0
            if stable is not None and stable.channel:
                self._check_kept(stable, target, record, own, first)
        raise AssertionError  # pragma: no cover - rows come, or an error does

    def _check_kept(
        self, stable: Stable | None, target: float | None, record: Record, part: Since, first: Mapping[str, int]
    ) -> None:
        """Refuse a record in which what was steady is so no longer.

        Raises
        ------
        InstrumentError
            ``left_stable``.
        """
        if stable is None:
            return
        if stable.instrument != record.instrument:
            found = self._taken.of(stable.instrument)
            part = found.part(first[stable.instrument], len(found))
        if not len(part):
            return
        if stable.still:
            if not conditions.stays_at_rest(part.values(stable.still), part.time_ns):
                raise InstrumentError("it moved while it was recorded", code="left_stable")
            return
        values = part.values((stable.channel,))[:, 0]
        middle = target if target is not None else 0.5 * (float(np.nanmin(values)) + float(np.nanmax(values)))
        off = np.abs(values - middle)
        if not np.all(off <= stable.within * (1.0 + 1e-9)):
            worst = values[int(np.nanargmax(off))]
            what = (
                f"{stable.channel} was {worst:g} while it was recorded, {middle:g} within {stable.within:g} is wanted"
            )
            raise InstrumentError(what, code="left_stable")
