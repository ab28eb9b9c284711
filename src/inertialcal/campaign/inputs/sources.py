"""Sources: recordings and tables made ready for a procedure, the same way from a folder or from memory.

A ``Store`` gives what a file holds. A ``Ready`` source is a recording of it with its entry and its sensor; after that
nothing knows where a recording came from.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...core.batches import every
from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.influence import Standards
from ...core.key import AXES
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.results import Row
from ...core.times import instant_text
from ...core.unit.magnitudes import are_possible, check_readings
from ...core.units import convert, factor, kind, parse_quantity, si_unit
from ...files import read, read_table
from ...files.budget import ANALYSIS, AS_WIDE, STREAMED, claim_recording
from ...files.reader import Request
from ...files.registry import Parsed, read_recording
from ...files.source import load as load_file
from ...files.text.headers import full_name
from ...files.text.table import Table
from ...files.time.window import Window
from ...procedures.protocol import Exclusion, Facts, InputSpec
from ...procedures.recorded import CLOCK, recorded_rows, saves_curve
from ...sensors.chain.conversion import convert as convert_counts
from ...sensors.chain.converter import Chain
from ...sensors.model.sensor_model import SensorModel
from ..file.recordings import Clock, RecordingEntry
from ..file.schema import Site, Test
from ..file.sensors import Sensor
from .chains import RAW, body_scale_factors, build_chain, output_unit, recorded_chain, scale_factors
from .channels import TEMPERATURE, in_body_axes, in_windows, one_factor, windowed
from .duplicates import Content, content_of_recording, content_of_table
from .gate import Gate, passed, without_stuck
from .ground import ChainModel, chain_model
from .sense import sensible

REFERENCES = {"reference": "reference_voltage", "temperature_reference": "temperature_reference_voltage"}
MIXED = 1e-6  # of a direction cosine that is neither 0 nor 1
ON_TIME = ("time_backwards", "stamps_not_used", "sample_rate_disagrees", "header_repeated")  # codes of the reader
T = TypeVar("T")


class Store(Protocol):
    """What files hold: a folder, or recordings in memory."""

    @property
    def folder(self) -> Path | None:
        """In which a ground model lies; None in memory."""
        ...

    def recording(self, entry: RecordingEntry, required: Sequence[str]) -> Recording:
        """Return a recording as its file has it."""
        ...

    def table(self, file: str, text: Mapping[str, Any] | None = None) -> Table:
        """Return a reduced table, its text read as is said."""
        ...

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        ...

    def read_file(self, file: str, read_it: Callable[[Any], T]) -> tuple[T, str]:
        """Return what another file says, and its SHA-256; empty in memory."""
        ...


def reading_of(entry: RecordingEntry) -> dict[str, Any]:
    """Return what an entry says of how its file is read, as `files.read` takes it."""
    clock = entry.clock or Clock()
    return {
        "time_column": clock.column, "sample_rate": clock.sample_rate, "start": clock.start, "stop": clock.stop,
        "mission_start": clock.mission_start, "frame": entry.frame, "topics": entry.topics,
        **text_of(entry),
    }  # fmt: skip


def request_of(entry: RecordingEntry, required: Sequence[str]) -> Request:
    """Return what an entry says of how its file is read, as readers take it."""
    clock = entry.clock or Clock()
    return Request(sample_rate=clock.sample_rate, time_column=clock.column, required=required,
                   window=Window(clock.start, clock.stop, clock.mission_start), frame=entry.frame,
                   topics=entry.topics, **text_of(entry))  # fmt: skip


def text_of(entry: RecordingEntry) -> dict[str, Any]:
    """Return what an entry says of its text, as `files.read` takes it; nothing where it says nothing."""
    return {} if entry.text is None else entry.text.model_dump(exclude_none=True)


def table_of(text: Mapping[str, Any]) -> dict[str, Any]:
    """Return of what is said of a text that which `files.read_table` takes: cells of dates stay text there."""
    return {name: value for name, value in text.items() if name != "dates"}


@dataclass(frozen=True)
class Folder:
    """A campaign folder."""

    folder: Path

    def path(self, file: str) -> Path:
        """Return where a file lies that the campaign names."""
        return self.folder / file

    def recording(self, entry: RecordingEntry, required: Sequence[str]) -> Recording:
        """Return a recording as its file has it."""
        return read(self.path(entry.file), required=required, **reading_of(entry))

    def table(self, file: str, text: Mapping[str, Any] | None = None) -> Table:
        """Return a reduced table."""
        return read_table(self.path(file), **table_of(text or {}))

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        return self.path(file).is_file()

    def read_file(self, file: str, read_it: Callable[[Any], T]) -> tuple[T, str]:
        """Return what another file says, and its SHA-256."""
        path = self.path(file)
        digest = load_file(path).sha256  # before it is read: a change in between shows in the end
        return read_it(path), digest


HELD = 2**28  # bytes of columns that wait for the next test which reads them


@dataclass(frozen=True, eq=False)
class ReadOnce(Folder):
    """A campaign folder whose recordings are read once, however many tests take them.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    waiting : Counter of str
        How many tests have yet to read a file; its columns are kept that long, as far as `HELD` goes.
    """

    waiting: Counter[str] = field(default_factory=Counter[str])
    absent: set[str] = field(default_factory=set[str])  # Files that were looked for and were not there
    _parsed: dict[str, Parsed] = field(default_factory=dict[str, Parsed])
    _archived: dict[tuple[str, str], Recording] = field(default_factory=dict[tuple[str, str], Recording])
    _tables: dict[str, Table] = field(default_factory=dict[str, Table])

    def recording(self, entry: RecordingEntry, required: Sequence[str]) -> Recording:
        """Return a recording as its file has it."""
        which = (entry.file, repr(sorted(reading_of(entry).items(), key=str)))
        if which in self._archived:
            return self._archived[which]
        parsed = self._parsed.setdefault(entry.file, {})
        found = read_recording(self.path(entry.file), request_of(entry, required), parsed)
        if not parsed:
            self._archived[which] = found
        return found

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        found = super().has(file)
        if not found:
            self.absent.add(file)
        return found

    def table(self, file: str, text: Mapping[str, Any] | None = None) -> Table:
        """Return a reduced table."""
        if file not in self._tables:
            self._tables[file] = super().table(file, text)
        return self._tables[file]

    def leave(self, files: Iterable[str]) -> None:
        """Note that a test has read files: what no other waits for is forgotten, and what is too much to be kept."""
        self.waiting.subtract({*files})
        for file in [name for name in self._tables if self.waiting[name] <= 0]:
            del self._tables[file]
        held = 0
        for file in list(self._parsed):
            archived = {which: one for which, one in self._archived.items() if which[0] == file}
            held += sum(c.values.nbytes for content, _ in self._parsed[file].values() for c in content.columns)
            held += sum(channel.data.nbytes for one in archived.values() for channel in one.channels)
            if self.waiting[file] <= 0 or held > HELD:
                del self._parsed[file]
                for which in archived:
                    del self._archived[which]


@dataclass(frozen=True, eq=False)
class Memory:
    """Recordings by file, of a rig or read before; what else belongs to them by its file, too."""

    held: Mapping[str, Recording]
    extras: Mapping[str, Any] = field(default_factory=dict[str, Any])
    folder: Path | None = None

    def recording(self, entry: RecordingEntry, required: Sequence[str]) -> Recording:
        """Return a recording as given."""
        return self.held[entry.file]

    def table(self, file: str, text: Mapping[str, Any] | None = None) -> Table:
        """Return a reduced table."""
        found = self.extras[file]
        assert isinstance(found, Table)  # noqa: S101 - whoever filled the store
        return found

    def has(self, file: str) -> bool:
        """Return whether something was given under the name of a file."""
        return file in self.extras

    def read_file(self, file: str, read_it: Callable[[Any], T]) -> tuple[T, str]:
        """Return what was given under the name of a file."""
        found: T = self.extras[file]
        return found, ""


@dataclass(frozen=True, eq=False)
class Ready:
    """A source: an entry of a store with its sensor, as ``procedures.protocol.Source`` has it."""

    store: Store
    name: str  # In the campaign
    entry: RecordingEntry
    sensor: Sensor
    facts: Facts
    spec: InputSpec
    of_test: Test
    chain: Chain | None = None
    screening: bool = True
    gate: Gate = field(default_factory=Gate)
    remarks: list[Remark] = field(default_factory=list[Remark])  # Of the gate
    exclusions: list[Exclusion] = field(default_factory=list[Exclusion])  # Of the gate
    _chosen: list[int] = field(default_factory=list[int])
    _hashes: dict[str, str] = field(default_factory=dict[str, str])

    @property
    def file(self) -> str:
        """Its file, as the campaign names it."""
        return self.entry.file

    @property
    def run(self) -> str:
        """Power-up."""
        return self.entry.run or ""

    @property
    def test(self) -> str:
        """Name of the test that reads it."""
        return self.of_test.id

    @property
    def alone(self) -> bool:
        """Whether the test reads no other."""
        return len(self.of_test.recordings) == 1

    @property
    def groups(self) -> Sequence[str] | None:
        """Rows of a table that are chosen, by their group."""
        return self.of_test.groups

    @property
    def windows(self) -> Sequence[tuple[int, int]] | None:
        """Instants between which readings are chosen."""
        return self.of_test.windows

    @property
    def sample_rate(self) -> float | None:
        """Of a recording that was read [Hz]; None where it has none, or was not read."""
        raw: Recording | None = self.__dict__.get("raw")
        return None if raw is None else raw.sample_rate

    @property
    def span(self) -> tuple[int, int] | None:
        """First and last instant (UTC) of the readings that are chosen [ns]; None where a recording does not say."""
        raw: Recording | None = self.__dict__.get("raw")
        if raw is None or raw.epoch != "utc":
            return None
        if self.windows:
            ends = [end for window in self.windows for end in window]
            return min(ends), max(ends)
        if raw.time_ns is None or not len(raw.time_ns):
            return None
        return int(raw.time_ns[0]), int(raw.time_ns[-1])

    @property
    def days(self) -> set[str]:
        """Days (UTC) of the readings that are chosen; the empty one where a recording does not say its day."""
        return {""} if self.span is None else {instant_text(end)[:10] for end in self.span}

    @property
    def on_time(self) -> tuple[Remark, ...]:
        """What the reader said of stamps and sample rate, whatever the procedure makes of them."""
        raw: Recording | None = self.__dict__.get("raw")
        found = () if raw is None else raw.remarks
        return tuple(replace(one, where=one.where or self.file) for one in found if one.code in ON_TIME)

    @property
    def is_table(self) -> bool:
        """Whether it is a reduced table."""
        return self.entry.channels is None

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        return self.store.has(file)

    def read_file(self, file: str, read_it: Callable[[Any], T]) -> T:
        """Return what another file says of it."""
        found, digest = self.store.read_file(file, read_it)
        if digest:
            self._hashes[file] = digest
        return found

    # ---- tables -----------------------------------------------------------------------------------------------

    @cached_property
    def _table(self) -> Table:
        return self.store.table(self.entry.file, {"topics": self.entry.topics, **text_of(self.entry)})

    def table(self) -> Table:
        """Return the reduced table."""
        return self._table

    def chose(self, rows: int, without_rate: int = 0) -> None:
        """Note how many rows of a table the test uses."""
        self._chosen[:] = [rows, without_rate]

    def in_si(self, values: Array, unit: str, axis: str) -> Array:
        """Return readings of a table in SI: counts through the chain, volts over the scale factor."""
        if kind(unit) in RAW:
            chain = self._table_chain(unit, axis)
            if chain.reference == "channel":
                what = f"recordings.{self.name}: counts, and the reference voltage is a channel that the table lacks"
                do = "Give readings in volts above the reference"
                raise DataError(what, self._table.source.path, do=do, code="missing_reference")
            taken = convert(values, unit, chain.input_unit)
            made = convert_counts(chain, taken[:, None], place=self._table.where)
            found = np.asarray(made.readings)[:, 0]
        else:
            found = convert(values, unit, si_unit(unit))
        check_readings(axis, found, si_unit(unit), self._table.where)
        return found

    def all_in_si(self, values: Array, unit: str, axes: Sequence[str]) -> Array:
        """Return the same of several axes, shape (k, n), at once where a factor is all."""
        if kind(unit) not in RAW:
            found = convert(values, unit, si_unit(unit))
            if are_possible(found):
                return found
        return np.array([self.in_si(one, unit, axis) for one, axis in zip(values, axes, strict=True)])

    def factor(self, unit: str, axis: str) -> float:
        """Return SI units a unit of the table, for differences."""
        if kind(unit) not in RAW:
            return factor(unit, si_unit(unit))
        chain = self._table_chain(unit, axis)
        assert chain.scale_factor is not None  # noqa: S101 - checked with the entry
        per_output = chain.step / float(np.ravel(chain.gain)[0]) / float(np.ravel(chain.scale_factor)[0])
        return factor(unit, chain.input_unit) * per_output

    def _table_chain(self, unit: str, axis: str) -> Chain:
        """Return the chain of readings in a unit; volts beside a measured reference stand above it already."""
        chain = recorded_chain(build_chain(self.sensor, (axis,)), [unit])
        measured = chain.reference == "channel" and chain.input_unit == "V"
        return replace(chain, reference=0.0) if measured else chain

    # ---- recordings -------------------------------------------------------------------------------------------

    @cached_property
    def model(self) -> ChainModel | None:
        """Ground model of the sensor, where the procedure takes readings after one."""
        return None if self.spec.ground_model == "refused" else chain_model(self.sensor, self.store.folder)

    @property
    def ground(self) -> SensorModel | None:
        """Ground model that a file of the chain gives."""
        found = None if self.model is None or not self.model.file else self.model
        return None if found is None else found.model.base

    @cached_property
    def raw(self) -> Recording:
        """As the store has it, columns called as the campaign calls them: with or without the unit in brackets."""
        channels = self.entry.channels or {}
        axes = [channels[axis].column for axis in channels if axis in AXES]
        required = [] if self.spec.missing else axes
        recording = self.store.recording(self.entry, required)
        if isinstance(self.store, Folder):
            said = {one.column for one in channels.values()}.difference(recording.names)
            called = {full: name for name in said if (full := full_name(recording.names, name)) not in (None, name)}
            needed = [full for full, name in called.items() if name in required]
            if not all(_whole(recording.channel(one).data) for one in needed):  # Under its full name it is refused
                recording = self.store.recording(self.entry, [str(full_name(recording.names, one) or one)
                                                              for one in required])  # fmt: skip
            if called:
                named = tuple(replace(one, name=called.get(one.name, one.name)) for one in recording.channels)
                recording = replace(recording, channels=named)
            claim_recording(recording, STREAMED if self.spec.streamed else AS_WIDE if self.spec.as_wide else ANALYSIS)
        return recording

    @cached_property
    def whole(self) -> Recording:
        """In body axes, SI, named by role."""
        entry, sensor, spec = self.entry, self.sensor, self.spec
        if self.model is not None and any(remark.code == "not_sensor_axes" for remark in self.raw.remarks):
            what, why = f"recordings.{self.name}: its axes are not those of the sensor", "the ground model is for those"
            raise DataError(what, entry.file, why, 'Say frame = "sensor"', "not_sensor_axes")
        chain = self.chain
        kept = spec.ground_model == "bias_kept"
        read = {one.column for one in (entry.channels or {}).values()} & {*self.raw.names}
        for given in (self.raw.channel(channel) for channel in read):
            check_readings(given.name, given.data, given.unit, self.raw.place)
        body = in_body_axes(self.raw, self.name, entry, sensor, chain, self.model, kept, spec.as_wide)
        looked_at = {id(self.raw.channel(channel).data) for channel in read}
        for one in body.channels:
            if one.name in AXES and id(one.data) not in looked_at:
                check_readings(one.name, one.data, one.unit, body.place)
        chosen = in_windows(body, self.of_test.windows)
        still = spec.still or spec.screening != "moving"
        key = (self.name, str(self.of_test.windows), still, spec.ground_model)
        found = sensible(self.name, entry, self.facts, self.raw, body,
                         at_rest=still, chosen=chosen, mounting=sensor.mounting,
                         known=self.gate.changed, key=key,
                         scaled=self.model is None and one_factor(entry, sensor, chain))  # fmt: skip
        body = found.recording
        self.remarks.extend(found.remarks)
        self.exclusions.extend(found.exclusions)
        if self.screening and spec.screening != "own":
            found = passed(self.gate, self.name, entry, sensor, self.raw, body,
                           at_rest=spec.screening == "at_rest", chosen=chosen, chain=chain)  # fmt: skip
            body = found.recording
            self.remarks.extend(found.remarks)
            self.exclusions.extend(found.exclusions)
        if self.screening:
            found = without_stuck(self.name, entry, self.raw, body)
            body = found.recording
            self.remarks.extend(found.remarks)
            self.exclusions.extend(found.exclusions)
        if spec.voltages:
            body = replace(body, channels=(*body.channels, *_reference_voltages(self.raw, entry, chain)))
        return in_body_names(body, entry, sensor) if spec.by_body else body

    @cached_property
    def _parts(self) -> list[Recording]:
        return [replace(one, source=replace(one.source, path=self.entry.file)) for one in self._in_windows()]

    def _in_windows(self) -> Iterator[Recording]:
        test = self.of_test
        if not test.windows or self.spec.windows == "refused":
            yield self.whole
        elif self.spec.windows == "mask":
            yield windowed(self.whole, test)
        else:
            for window in test.windows:
                try:
                    yield windowed(self.whole, test.model_copy(update={"windows": [window]}))
                except DataError as error:
                    if error.problems[0].code != "nothing_left" or self.alone:
                        raise

    def recordings(self) -> list[tuple[str, Recording]]:
        """Return each part with its label."""
        several = len(self._parts) > 1
        labels = [f"{self.name}, window {i}" for i in range(1, len(self._parts) + 1)] if several else [self.name]
        return list(zip(labels, self._parts, strict=True))

    def recorded(self) -> list[Row]:
        """Return what every recording gives, as it was saved: sampling, saves, built-in test; nothing for a table."""
        if self.is_table:
            return []
        chain, channels = self.chain, self.entry.channels or {}
        sensed_by = _sensed_by(self.sensor) or {axis: axis for axis in self.sensor.axes}
        tested: dict[str, Array] = {}
        for body, sensed in sensed_by.items():
            one = channels.get(f"validity_{sensed}")
            if chain is not None and one is not None and sensed in chain.axes:
                tested[body] = _at_converter(chain, self.raw.channel(one.column), one.unit)
        lowest = None if chain is None else chain.validity_minimum
        return recorded_rows(self.name, self.raw, tested, lowest, self.facts.standards.get(CLOCK))

    @property
    def saves(self) -> Curve | None:
        """How often it was saved after which time; None of a table, and where no save is late."""
        return None if self.is_table else saves_curve(self.name, self.raw)

    @property
    def pressures(self) -> Array:
        """What its pressure channel says over what the test takes [Pa]; empty where it has none."""
        one = None if self.is_table else (self.entry.channels or {}).get("pressure")
        if one is None:
            return np.empty(0)
        data = np.asarray(self.raw.channel(one.column).data, dtype=float)
        chosen = in_windows(self.raw, self.of_test.windows)
        known = data[np.isfinite(data) & (True if chosen is None else chosen)]
        return convert(known, one.unit, "Pa")

    @property
    def content(self) -> Content:
        """What it holds, to be compared with other recordings."""
        if self.is_table:
            return content_of_table(self.name, self.entry, self.table())
        chosen = in_windows(self.raw, self.of_test.windows)
        return content_of_recording(self.name, self.entry, self.raw, chosen)

    # ---- what the test draws on -------------------------------------------------------------------------------

    @property
    def inputs(self) -> dict[str, str]:
        """SHA-256 of its files, by path in the campaign."""
        if self.is_table:
            return {self.entry.file: self._table.source.sha256} | self._hashes
        model = self.model
        of_model = {model.file: model.sha256} if model is not None and model.file else {}
        return {self.entry.file: self.raw.source.sha256} | self._hashes | of_model

    @property
    def origin(self) -> Origin:
        """How much of it the test takes."""
        file = self.entry.file
        if self.is_table:
            chosen, without = self._chosen or (len(self._table), 0)
            return Origin(self.name, file, self._table.source.sha256, "table", len(self._table), chosen, without)
        chosen = sum(len(one) for one in self._parts)
        raw, by = self.raw, self.raw.compensated_by
        return Origin(self.name, file, raw.source.sha256, "recording", len(raw), chosen, compensated_by=by)


def _whole(data: NDArray[Any]) -> bool:
    """Return whether all are finite numbers."""
    return data.dtype.kind in "iu" or (data.dtype.kind == "f" and every(data, lambda part: np.isfinite(part).all()))


def facts_of(sensor: Sensor, standards: Standards, site: Site | None = None) -> Facts:
    """Return what is known of a sensor, the site and the standards before any reading."""
    site = site or Site()
    known = None if sensor.kind == "other" else sensor.kind
    si = si_unit(sensor.unit) if known else sensor.unit
    ends = None if sensor.range is None else [parse_quantity(text).to(si) for text in sensor.range]
    counted = output_unit(sensor) != "V"
    factors = scale_factors(sensor, tuple(sensor.axes)) if known else None
    is_input = sensor.chain.kind == "none" and kind(sensor.unit) not in RAW
    return Facts(
        kind=known,
        unit=sensor.unit,
        si=si,
        axes=tuple(sensor.axes),
        latitude=site.latitude,
        gravity=site.gravity,
        height=site.height,
        standards=standards,
        scale_factor=None if counted else body_scale_factors(sensor),
        thermometers=_thermometers(sensor),
        input_range=None if ends is None else (min(ends), max(ends)),
        gate=sensor.chain.gate,
        output_unit=si if sensor.chain.kind == "none" else output_unit(sensor),
        output_scale_factor=1.0 if is_input else None if factors is None else float(np.ravel(factors)[0]),
        oblique=_is_oblique(sensor),
        cut_off=sensor.cut_off,
    )


def in_body_names(recording: Recording, entry: RecordingEntry, sensor: Sensor) -> Recording:
    """Return a recording with temperatures and reference voltages named by the body axis of their sensor.

    Raises
    ------
    DataError
        If the mounting mixes sensors, so that no temperature is that of a body axis.
    """
    if sensor.mounting is None:
        return recording  # named by the axis already
    sensed_by = _sensed_by(sensor)
    if sensed_by is None and any(f"{TEMPERATURE}_{axis}" in recording.names for axis in AXES):
        what = "the mounting mixes sensors: no thermometer is that of one body axis"
        raise DataError(what, entry.file, do="Give one channel temperature, or a mounting without mixing")
    stems = (TEMPERATURE, *REFERENCES.values())
    names = {f"{stem}_{sensed}": f"{stem}_{body}" for stem in stems for body, sensed in (sensed_by or {}).items()}
    channels = tuple(replace(one, name=names.get(one.name, one.name)) for one in recording.channels)
    return replace(recording, channels=channels)


def _sensed_by(sensor: Sensor) -> dict[str, str] | None:
    """Return the sensor that feels each body axis; None where the mounting mixes them."""
    if sensor.mounting is None:
        return {axis: axis for axis in sensor.axes}
    size = np.abs(np.array(sensor.mounting))
    if not np.all(np.isclose(size, 0.0) | np.isclose(size, 1.0)):
        return None
    return {AXES[body]: AXES[int(np.argmax(size[:, body]))] for body in range(3)}


def _is_oblique(sensor: Sensor) -> bool:
    if sensor.mounting is None:
        return False
    cosines = np.abs(np.array(sensor.mounting))
    return not bool(np.all((cosines < MIXED) | (cosines > 1.0 - MIXED)))


def _reference_voltages(raw: Recording, entry: RecordingEntry, chain: Chain | None) -> list[Channel]:
    """Return the reference voltages of the sensors [V], NaN at the ends of the converter."""
    found: list[Channel] = []
    if chain is None or chain.output_unit != "V":
        return found
    for counted, voltage in REFERENCES.items():
        for axis in chain.axes:
            named = (entry.channels or {}).get(f"{counted}_{axis}")
            if named is not None:
                codes = np.asarray(raw.channel(named.column).data, dtype=np.float64)
                volts = _at_converter(chain, raw.channel(named.column), named.unit)
                if chain.codes is not None:
                    volts = np.where((codes > chain.codes[0]) & (codes < chain.codes[1]), volts, np.nan)
                found.append(Channel(f"{voltage}_{axis}", volts, "V", "chain", axis))
    return found


def _at_converter(chain: Chain, channel: Channel, unit: str) -> Array:
    """Return the voltage of a channel at the converter [V], recorded in codes or in volts."""
    values = np.asarray(channel.data, dtype=np.float64)
    return chain.step * values if chain.input_unit == "count" else convert(values, unit, chain.input_unit)


def _thermometers(sensor: Sensor) -> dict[str, tuple[float, float, float]] | None:
    """Return the temperature channels by body axis; None where there is none, or the mounting mixes sensors."""
    sensed_by = _sensed_by(sensor)
    if sensor.chain.kind not in ("adc", "output") or sensor.chain.thermometer is None or sensed_by is None:
        return None
    chain = build_chain(sensor)
    given = chain.thermometer
    if given is None:
        return None
    columns = (np.broadcast_to(one, len(chain.axes)) for one in (given.slope, given.voltage, given.temperature))
    own = {axis: (float(a), float(b), float(c)) for axis, a, b, c in zip(chain.axes, *columns, strict=True)}
    return {body: own[sensed] for body, sensed in sensed_by.items() if sensed in own}


@dataclass(frozen=True)
class Origin:
    """One recording of a test."""

    name: str  # In the campaign
    file: str  # Path in its folder
    sha256: str  # Of the file
    kind: Literal["table", "recording"]  # Rows are dwells, or samples
    rows: int  # In the file
    chosen: int  # Of them, inside the groups and windows of the test
    # Rows of a table without an applied rate: no dwells, whatever is chosen; not among ``chosen``
    without_rate: int = 0
    compensated_by: str = ""  # Model that was applied to it before; empty for readings

    @property
    def not_chosen(self) -> int:
        """Rows with a rate, or samples, outside the groups and windows of the test."""
        return self.rows - self.chosen - self.without_rate

    @property
    def counts(self) -> str:
        """What a row is: ``"row"`` or ``"sample"``."""
        return "row" if self.kind == "table" else "sample"
