"""Steps of a sequence, from ``[[sequence.steps]]`` or the rows of a schedule; judged before anything is connected."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.errors import DataError, InertialcalError, Problem
from ...core.schema.toml import At
from ...core.units import convert, same_dimension
from ...files.text.headers import bare_name
from ...files.text.table import Table, read_table
from ..instruments.dialect import Dialect, value_in
from .entries import RecordEntry, ScheduleEntry, SequenceEntry, SequenceStepEntry, StableEntry

Set = tuple[tuple[str, str, float], ...]  # Instrument, quantity, value
Values = Callable[[Mapping[str, str], str, tuple[str | int, ...]], tuple[Set, list[Problem]]]
Path_ = tuple[str | int, ...]
SPANS = ("start", "stop")  # columns of a schedule [s]


@dataclass(frozen=True)
class Stable:
    """What has to be steady."""

    instrument: str
    still: tuple[str, ...]  # Channels at rest
    channel: str  # Channel that is held; empty: none
    follows: tuple[str, str] | None  # Instrument and quantity whose value it has to have
    at: float | None  # Value that it has to have, in its unit; None: that of follows, or whichever it is held at
    within: float  # In its unit
    lasting: float  # [s]
    limit: float  # [s]


@dataclass(frozen=True)
class Record:
    """What is recorded, and for how long."""

    instrument: str
    least: float  # [s]
    most: float  # [s]
    channels: tuple[str, ...]
    u: float | None  # Standard uncertainty of the mean that is wanted, in the unit of the channels; None: none


@dataclass(frozen=True)
class SequenceStep:
    """A step."""

    number: int  # From 1
    name: str
    recording: str
    prompt: str
    values: Set
    hold: float  # [s]
    stable: Stable | None
    record: Record | None
    kept: tuple[tuple[str, str], ...] = ()  # Column and cell that the schedule as it was run has too

    @property
    def least(self) -> float:
        """Time that it takes at least [s]."""
        stable = 0.0 if self.stable is None else self.stable.lasting
        return self.hold + stable + (0.0 if self.record is None else self.record.least)

    @property
    def most(self) -> float:
        """Time that it takes at most, its prompt apart [s]."""
        stable = 0.0 if self.stable is None else self.stable.limit
        return self.hold + stable + (0.0 if self.record is None else self.record.most)


def read_steps(
    entry: SequenceEntry, folder: Path, dialects: Mapping[str, Dialect], values: Values, at: At
) -> tuple[list[SequenceStep], list[Problem]]:
    """Return the steps of a sequence, and what is wrong with them.

    Parameters
    ----------
    entry : SequenceEntry
        What LAB.toml says.
    folder : path
        In which a schedule stands.
    dialects : mapping of str to Dialect
        By instrument.
    values : callable
        What is set, step and key path, for messages -> values and problems.
    at : callable
        Key path -> place in LAB.toml.
    """
    reading = _Reading(entry, folder, dialects, values, at)
    problems = list(reading.problems())
    return reading.steps, problems


class _Reading:
    """What is looked up while problems are looked for."""

    def __init__(
        self, entry: SequenceEntry, folder: Path, dialects: Mapping[str, Dialect], values: Values, at: At
    ) -> None:
        self.entry, self.folder, self.dialects, self.values, self.at = entry, folder, dialects, values, at
        self.steps: list[SequenceStep] = []
        rows = [name for name, one in dialects.items() if one.layout is not None]
        self.recorded = entry.instrument or (rows[0] if len(rows) == 1 else "")
        self.rows = rows

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong, and keep the steps."""
        if self.recorded not in self.rows:
            what = f"sequence.instrument: {self.recorded!r} gives no rows" if self.recorded else "sequence.instrument"
            what += "" if self.recorded else " is missing: more than one instrument gives rows, or none"
            do = f"There are: {', '.join(self.rows) or 'none'}"
            yield Problem(what, self.at("sequence", "instrument"), do=do, code="unknown_name")
            return
        if bool(self.entry.steps) == (self.entry.schedule is not None):
            do = "Give either [[sequence.steps]] or [sequence.schedule]"
            yield Problem("sequence: no steps, or two kinds of them", self.at("sequence"), do=do, code="missing_key")
            return
        for number, step in enumerate(self.entry.steps):
            yield from self._step(step, f"sequence.steps.{number}", ("sequence", "steps", number))
        if self.entry.schedule is not None:
            yield from self._schedule(self.entry.schedule)

    def _step(self, step: SequenceStepEntry, called: str, path: Path_, file: str = "") -> Iterator[Problem]:
        values, problems = self.values(step.set, called, (*path, "set"))
        number = len(self.steps) + 1
        stable, record, more = None, None, list[Problem]()
        if step.stable is not None:
            stable, own = self._stable(step.stable, called, (*path, "stable"))
            more += own
        if step.record is not None:
            record, own = self._record(step.record, called, (*path, "record"))
            more += own
        for one in [*problems, *more]:
            yield Problem(one.what, file or one.where, one.why, one.do, one.code)
        name = step.name or f"step {number}"
        recording = step.recording or f"step_{number:04d}"
        self.steps.append(SequenceStep(number, name, recording, step.prompt, values, step.hold, stable, record))

    # ---- what is awaited and recorded ----

    def _channels(self, names: tuple[str, ...], instrument: str, where: str) -> tuple[list[str], list[Problem]]:
        """Return the units of channels, and which of them are not there."""
        layout = self.dialects[instrument].layout if instrument in self.dialects else None
        have = {} if layout is None else {one.name: one.unit for one in layout.channels}
        missing = [
            Problem(f"{instrument} has no channel {name!r}", where, do=f"There are: {', '.join(have) or 'none'}",
                    code="unknown_name")
            for name in names if name not in have
        ]  # fmt: skip
        return [have.get(name, "") for name in names], missing

    def _stable(self, said: StableEntry, called: str, path: Path_) -> tuple[Stable | None, list[Problem]]:
        where, instrument = self.at(*path), said.instrument or self.recorded
        judged = (*said.still, *([said.channel] if said.channel else []))
        units, problems = self._channels(judged, instrument, where)
        if bool(said.still) == bool(said.channel):
            do = 'Say still = ["acc_x", ...], or channel = "..." and within = "..."'
            problems.append(Problem(f"{called}.stable: what has to be steady?", where, do=do, code="missing_key"))
        if problems:
            return None, problems
        if said.still:
            return Stable(instrument, said.still, "", None, None, 0.0, said.lasting, said.limit), []
        if not said.within or (said.at and said.follows):
            do = 'Say within = "...", and at or follows, not both'
            return None, [Problem(f"{called}.stable: how steady?", where, do=do, code="missing_key")]
        try:
            within = value_in(said.within, units[0], difference=True)
            at = value_in(said.at, units[0]) if said.at else None
        except DataError as error:
            return None, [Problem(f"{called}.stable: {error.problems[0].what}", where, do=error.problems[0].do,
                                  code="wrong_value")]  # fmt: skip
        follows, problems = self._followed(said, units[0], called, where)
        return Stable(instrument, (), said.channel, follows, at, within, said.lasting, said.limit), problems

    def _followed(
        self, said: StableEntry, unit: str, called: str, where: str
    ) -> tuple[tuple[str, str] | None, list[Problem]]:
        """Return what a channel follows."""
        if not said.follows:
            return None, []
        name, _, quantity = said.follows.partition(".")
        settings = self.dialects[name].settings if name in self.dialects else {}
        if quantity not in settings:
            what = f"{called}.stable.follows: nothing is called {said.follows}"
            return None, [Problem(what, where, do='Write it like "table.rate"', code="unknown_name")]
        own = settings[quantity].unit
        if unit and own and not same_dimension(unit, own):
            what = f"{called}.stable: {said.channel} [{unit}] cannot follow {said.follows} [{own}]"
            return None, [Problem(what, where, do="Name a channel of its kind", code="wrong_value")]
        return (name, quantity), []

    def _record(self, said: RecordEntry, called: str, path: Path_) -> tuple[Record | None, list[Problem]]:
        where = self.at(*path)
        units, problems = self._channels(said.channels, self.recorded, where)
        if bool(said.u) != bool(said.channels) or bool(said.u) != (said.limit is not None):
            what = f"{called}.record: u, channels and limit belong together"
            do = 'Write it like { for = "20 s", u = "0.001 deg/s", channels = ["x"], limit = "5 min" }'
            problems.append(Problem(what, where, do=do, code="missing_key"))
        most = said.least if said.limit is None else said.limit
        if most < said.least:
            what = f"{called}.record: limit is below for"
            problems.append(Problem(what, where, do="Give a longer limit", code="wrong_value"))
        if len(set(units)) > 1:
            what = f"{called}.record: channels in {', '.join(sorted(set(units)))}"
            problems.append(Problem(what, where, "one u is for all", "Name channels of one unit", "wrong_value"))
        if problems:
            return None, problems
        try:
            u = value_in(said.u, units[0], difference=True) if said.u else None
        except DataError as error:
            return None, [Problem(f"{called}.record: {error.problems[0].what}", where, do=error.problems[0].do,
                                  code="wrong_value")]  # fmt: skip
        if u is not None and not u > 0.0:
            return None, [Problem(f"{called}.record.u: {said.u} is not above zero", where, code="wrong_value")]
        return Record(self.recorded, said.least, most, said.channels, u), []

    # ---- a schedule ----

    def _schedule(self, said: ScheduleEntry) -> Iterator[Problem]:
        """Turn each row into a step."""
        path: Path_ = ("sequence", "schedule")
        try:
            table = read_table(self.folder / said.file)
            rows = list(self._rows(said, table))
            kept = [table.text(one) for one in said.keep]
        except InertialcalError as error:
            here = self.at(*path, "file")
            yield from (Problem(p.what, p.where or here, p.why, p.do, p.code) for p in error.problems)
            return
        for row, step, *cells in zip(table.rows, rows, *kept, strict=True):
            yield from self._step(step, f"row {row}", path, f"{said.file}:{row}")
            if cells:
                self.steps[-1] = replace(self.steps[-1], kept=tuple(zip(said.keep, cells, strict=True)))

    def _rows(self, said: ScheduleEntry, table: Table) -> Iterator[SequenceStepEntry]:
        numbers: dict[str, list[str]] = {}
        for target, column in said.set.items():
            unit = table.unit(column) or self._unit_of(target)
            numbers[target] = [f"{value!r} {unit}".rstrip() for value in table.numbers(column).tolist()]
        spans = self._spans(said, table)
        names = table.text(said.name) if said.name else tuple(f"row {row}" for row in table.rows)
        there = set(map(bare_name, table.names))
        recordings = table.text(said.recording) if said.recording in there else None
        prompts = table.text(said.prompt) if said.prompt in there else None
        for i, name in enumerate(names):
            record = said.record
            if record is not None and spans is not None:
                least = float(spans[i])
                limit = None if record.limit is None else max(record.limit, least)
                record = record.model_copy(update={"least": least, "limit": limit})
            yield SequenceStepEntry(
                name=name,
                recording=(recordings[i] if recordings is not None else said.recording) or None,
                prompt=prompts[i] if prompts is not None else said.prompt.replace("{name}", name),
                set={target: column[i] for target, column in numbers.items()},
                stable=said.stable,
                record=record,
            )

    def _unit_of(self, target: str) -> str:
        name, _, quantity = target.partition(".")
        settings = self.dialects[name].settings if name in self.dialects else {}
        return settings[quantity].unit if quantity in settings else ""

    def _spans(self, said: ScheduleEntry, table: Table) -> np.ndarray | None:
        """Return how long each row is recorded [s], where the table says it."""
        columns = [said.duration] if said.duration else list(SPANS)
        if not said.duration and not set(columns) <= set(map(bare_name, table.names)):
            return None
        found = [convert(table.numbers(one), table.unit(one) or "s", "s") for one in columns]
        spans = found[0] if said.duration else found[1] - found[0]
        wrong = np.flatnonzero(~(spans > 0.0))
        if len(wrong):
            raise DataError("no time to record", table.where(int(wrong[0])), do="Correct it", code="wrong_value")
        return spans
