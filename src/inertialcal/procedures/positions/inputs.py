"""Readings of a test of positions: recordings of accelerometers and of gyros on one clock, each of its own sensor.

Recordings of both sensors are paired in their order; gyros need the accelerometers of the same recording. Stamps may
differ (phone logs): then gyros are interpolated to those of the accelerometers to find rests, and nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import cast

import numpy as np

from ...core.batches import every
from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.key import AXES, Kind, Origin
from ...core.labelled import LabelledPart
from ...core.recording import SECOND, Channel, Recording, Times
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import convert, factor, kind
from ...core.unknowns import Unknowns
from ...core.unknowns import joined as unknowns_joined
from ...files.budget import ANALYSIS, claim_recording
from ...files.text.headers import heading
from ...files.text.table import Table
from ...signals.time.interpolation import interpolated
from ...signals.time.samples import samples_of
from ..corrections import between, corrected
from ..protocol import Correction, Source
from .entry import PositionsEntry, Rests
from .orientations import FACES, direction_of, parse_directions, runs_of, sections_of, turn_of
from .plan import Plan
from .readings import Readings, Triad, turn_problems
from .recordings import GYRO, Section, readings_from

TEMPERATURE = "temperature"
PREFIX: dict[str, str] = {"accelerometer": "acc", "gyro": "gyro"}
SATURATED = ("saturated", "rail")  # remarks
SAME_STAMP = 0.01  # of a sample interval, by which stamps of one clock may differ
NEAR_GRAVITY = 0.05  # of it, by which the length of a nominal input may be rounded or local gravity differ
OVERLAP = 0.5  # of the shorter recording, that must lie within the other


@dataclass(frozen=True, eq=False)
class Part:
    """A recording of one sensor, with where it comes from."""

    source: Source
    recording: Recording

    @property
    def kind(self) -> Kind | None:
        """Of its sensor."""
        return self.source.facts.kind


def readings_of(plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
    """Return the readings of the recordings of a test.

    Raises
    ------
    DataError
        If a recording cannot be read; ``no_accelerometers``; ``clocks_differ``; ``too_large``, with gyros.
    PlanError
        ``plans_differ`` if a correction leaves the bias at another temperature than the plan refers to.
    """
    _check_references(plan, corrections)
    tables = [one for one in sources if one.is_table]
    if tables and len(tables) < len(sources):
        what = f"test {sources[0].test!r} reads tables of rests and recordings"
        raise DataError(what, do="Make a test for each", code="wrong_value")
    if tables:
        return _read_tables(tables)
    parts = [Part(one, recording) for one in sources for _, recording in one.recordings()]
    whole = parts
    if corrections:
        made = corrected(corrections, [(one.source.name, one.recording) for one in parts])[0]
        parts = [replace(one, recording=recording) for one, recording in zip(parts, made, strict=True)]
    pairs = _paired(parts, sources[0].test)
    for one in parts:
        if one.kind == "gyro":
            claim_recording(one.recording, ANALYSIS)  # interpolated and filled as a whole
    both = [_joined(pair) for pair in pairs]
    joined, gyros = [one for one, _ in both], [own for _, own in both]
    sections = [_sections(pair, one) for pair, one in zip(pairs, joined, strict=True)]
    faces = any(_entry(one).orientations == [FACES] for one in sources)
    saturated = [any(_saturated(one) for one in pair if one.kind == "gyro") for pair in pairs]
    readings = _oriented(readings_from(plan, joined, sections, faces, saturated, gyros), pairs)
    return _with_unknowns(readings, corrections, _paired(whole, sources[0].test)) if corrections else readings


def _check_references(plan: Plan, corrections: Sequence[Correction]) -> None:
    """Refuse terms over temperature about another temperature than that at which a correction leaves the bias."""
    for one in corrections:
        other = one.reference_temperature
        if plan.temperature_order and other is not None and other != plan.reference_temperature:
            what = f"reference_temperature = {plan.reference_temperature:g} degC, that of {one.test} is {other:g} degC"
            why = f"after = {one.test!r} leaves the bias at {other:g} degC; the terms of both tests are added"
            do = f'Set reference_temperature = "{other:g} degC"'
            raise PlanError(what, why=why, do=do, code="plans_differ")


def _with_unknowns(readings: Readings, corrections: Sequence[Correction], pairs: Sequence[Sequence[Part]]) -> Readings:
    """Return readings with what is not known of corrections, position by position; ``pairs`` before any."""
    found: dict[Kind, Mapping[Origin, Unknowns]] = {}
    start, stop = cast("Times", readings.start_ns), cast("Times", readings.stop_ns)
    for at, one in enumerate(pairs[0]):
        units = {channel.unit for channel in one.recording.channels if channel.name in AXES}
        own = [correction for correction in corrections if correction.unit in units]
        cut = [
            (pairs[number][at].source.name, between(pairs[number][at].recording, int(start[k]), int(stop[k])))
            for k, number in enumerate(readings.recordings)
        ]
        off = corrected(own, cut)[1]
        if one.kind is not None and own:
            found[one.kind] = unknowns_joined(off, [1] * len(off))
    return replace(readings, taken_off=found)


def _saturated(part: Part) -> bool:
    """Return whether samples of a recording were left out at the end of the range."""
    return any(one.code in SATURATED for one in (*part.source.remarks, *part.recording.remarks))


def _paired(parts: Sequence[Part], test: str) -> list[list[Part]]:
    """Return each recording of accelerometers with that of the gyros of the same clock.

    Raises
    ------
    DataError
        ``no_accelerometers``, ``wrong_value`` if there are not as many of both.
    """
    acc = [one for one in parts if one.kind == "accelerometer"]
    gyro = [one for one in parts if one.kind == "gyro"]
    if not acc:
        do = "Add the recording of the accelerometers to recordings of the test"
        why = "gravity is what calibrates, and accelerometers feel it"
        raise DataError(f"test {test!r} has no recording of accelerometers", "", why, do, "no_accelerometers")
    if gyro and len(gyro) != len(acc):
        what = f"test {test!r}: {len(acc)} recording(s) of accelerometers and {len(gyro)} of gyros"
        raise DataError(what, why="they are paired in their order", do="Name as many of both", code="wrong_value")
    return [[one, other] for one, other in zip(acc, gyro, strict=True)] if gyro else [[one] for one in acc]


def _joined(pair: Sequence[Part]) -> tuple[Recording, Recording | None]:
    """Return one recording with channels ``acc_x``, ..., ``gyro_z``, in SI; that of gyros with stamps of their own."""
    apart = own_stamps([one.recording for one in pair])
    made: list[Channel] = []
    for one in pair:
        if len(one.recording) < 2:
            what, do = f"{len(one.recording)} sample(s)", "Record again, or name another file"
            raise DataError(what, one.source.file, "a position is a stretch at rest", do, "too_few_samples")
        missing = [axis for axis in AXES if axis not in one.recording.names]
        if missing:
            what = f"recordings.{one.source.name}: no channel {', '.join(missing)}"
            raise DataError(what, one.source.file, "positions need three axes", code="wrong_column")
        channels = [one.recording.channel(axis) for axis in AXES]
        for axis, channel in zip(AXES, channels, strict=True):
            if every(channel.data, lambda part: not np.isfinite(np.asarray(part, dtype=np.float64)).any()):
                what = f"channel {axis} of the {one.kind} holds no value"
                raise DataError(what, one.source.file, do="Name another column, or record again", code="no_values")
        made += [replace(c, name=f"{PREFIX[str(one.kind)]}_{c.name}") for c in channels]
    first = pair[0].recording
    made += [c for c in first.channels if c.name == TEMPERATURE]
    remarks = tuple(dict.fromkeys(remark for one in pair for remark in one.recording.remarks))
    if not apart:
        return replace(first, channels=tuple(made), remarks=remarks), None
    gyro = replace(pair[1].recording, channels=tuple(c for c in made if c.name in GYRO))
    stamps, onto = cast("Times", gyro.time_ns), cast("Times", first.time_ns)
    for sensor in (first, gyro):
        samples_of(
            sensor.channels[0].data, sensor.time_ns, sensor.sample_interval, sensor.place
        )  # refuses time that goes back
    values = dict(zip(GYRO, interpolated(gyro.array(GYRO), stamps, onto).T, strict=True))
    made = [replace(c, data=values[c.name]) if c.name in GYRO else c for c in made]
    return replace(first, channels=tuple(made), remarks=(*remarks, _joined_by_stamps(first, gyro))), gyro


def _entry(source: Source) -> PositionsEntry:
    return cast("PositionsEntry", source.entry)


def _sections(pair: Sequence[Part], recording: Recording) -> tuple[Section, ...]:
    """Return the labelled parts that an entry of a pair names; none where none does.

    Raises
    ------
    DataError
        As `sections_of`; ``unknown_name`` if a column of labels names no position and no turn.
    """
    source = next((one.source for one in pair if _entry(one.source).sections is not None), None)
    if source is None:
        return ()
    entry = _entry(source)
    named, turn = str(entry.sections), entry.turn
    if turn is not None and (problems := turn_problems(turn)):
        raise DataError(problems)
    if source.has(named):
        return tuple(section_of(one, recording, turn) for one in source.read_file(named, sections_of))
    if _is_label(named):
        return (named_section(named, 0, len(recording), turn),)
    runs = runs_of(source.table().text(named))
    known = [one for one in runs if _is_label(one.label)]
    if not known:
        labels = ", ".join(dict.fromkeys(one.label for one in runs))
        what = f"column {named!r} names no position and no turn: {labels[:120]}"
        raise DataError(what, source.file, do="Labels are like x_p, x_a, x_rot", code="unknown_name")
    return tuple(section_of(one, recording, turn) for one in known)


def _is_label(text: str) -> bool:
    return direction_of(text) is not None or turn_of(text) is not None


def section_of(said: LabelledPart, recording: Recording, turn: float | None) -> Section:
    """Return a labelled part in samples; a turn by its own angle, else by the one given [rad].

    Raises
    ------
    DataError
        ``no_time`` if it is in seconds and the recording has none.
    """
    start, stop = said.start, said.stop
    if said.seconds:
        seconds = recording.seconds
        if seconds is None:
            do = "Give the sample rate, or samples"
            raise DataError(f"section {said.label!r} is in seconds, the recording has no time", do=do, code="no_time")
        start, stop = (float(np.searchsorted(seconds, one)) for one in (start, stop))
    return named_section(said.label, round(start), round(stop), turn if said.angle is None else said.angle)


def named_section(label: str, start: int, stop: int, turn: float | None) -> Section:
    """Return samples [start, stop) as the position, or the turn by an angle [rad], that the label says.

    A turn whose angle nobody stated is one by 360 deg.
    """
    axis = turn_of(label)
    if axis is not None:
        angle = 2.0 * np.pi if turn is None else turn
        return Section(start, stop, axis=_triple(axis), angle=angle, name=label, assumed=turn is None)
    direction = direction_of(label)
    known = direction is not None and bool(np.isfinite(direction).all())
    return Section(start, stop, _triple(direction) if known and direction is not None else None, name=label)


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(one) for one in vector)
    return x, y, z


def own_stamps(pair: Sequence[Recording]) -> bool:
    """Return whether gyros have stamps of their own, on the clock of the accelerometers.

    Raises
    ------
    DataError
        ``clocks_differ`` if the recordings hardly overlap, or one has no stamps.
    """
    if len(pair) < 2:
        return False
    first, other = pair
    one, two = first.time_ns, other.time_ns
    if len(first) == len(other):
        if one is None and two is None:
            return False
        if one is not None and two is not None:
            most = SAME_STAMP * (first.sample_interval or 0.0) * SECOND
            if not len(first) or np.max(np.abs(one - two)) <= most:
                return False
    if one is not None and two is not None and min(len(one), len(two)) > 1:
        together = min(one[-1], two[-1]) - max(one[0], two[0])
        if together > OVERLAP * min(one[-1] - one[0], two[-1] - two[0]):
            return True
    what = f"{_span(first)}, {_span(other)}: not of one clock"
    why = "rotations of the gyros would belong to positions of another time"
    do = "Record both on one clock, or bring them to the same stamps"
    if one is None or two is None:
        what = f"{_span(first)}, {_span(other)}: stamps are not known"
        why = "samples of two sensors go together by them"
        do = "Add --time-column NAME, or --unit NAME=ns where its stamps are whole numbers"
    raise DataError(what, other.source.path, why, do, "clocks_differ")


def _joined_by_stamps(acc: Recording, gyro: Recording) -> Remark:
    """Say how two sensors with stamps of their own were joined."""
    one, two = cast("Times", acc.time_ns), cast("Times", gyro.time_ns)
    after = np.clip(np.searchsorted(two, one), 1, len(two) - 1)
    near = np.where(one - two[after - 1] <= two[after] - one, after - 1, after)
    inside = (one >= two[0]) & (one <= two[-1])
    apart = 1e-6 * np.percentile((two[near] - one)[inside], (0.0, 50.0, 100.0))
    out = [int(np.count_nonzero((a < b[0]) | (a > b[-1]))) for a, b in ((one, two), (two, one))]
    rates = [f"{number(one.sample_rate, 4)} Hz" if one.sample_rate else "no rate" for one in (acc, gyro)]
    what = (
        f"accelerometers ({rates[0]}) and gyros ({rates[1]}) have stamps of their own, taken as of one clock: the gyro "
        f"sample nearest to one of the accelerometers lies {number(apart[0], 3)} to {number(apart[2], 3)} ms from it "
        f"(median {number(apart[1], 3)} ms). Means at rest and rotations are of each sensor's own samples; where both "
        f"are needed at one time, straight lines between samples. Samples outside the overlap: accelerometers "
        f"{out[0]}, gyros {out[1]}"
    )
    return Remark("joined_by_stamps", "info", what, gyro.source.path, do="Check that both stamps are of one clock")


def _span(one: Recording) -> str:
    times = one.time_ns
    ends = "" if times is None or not len(times) else f" from {times[0] / SECOND:.12g} to {times[-1] / SECOND:.12g} s"
    return f"{Path(one.source.path).name}: {len(one)} samples{ends}"


def _read_tables(sources: Sequence[Source]) -> Readings:
    """Return the rows of tables as positions; those of the gyros stand in the same rows.

    Raises
    ------
    DataError
        ``no_accelerometers``; ``nan_in_required`` if a reading is missing; ``wrong_value`` for a scatter or number of
        samples that cannot be.
    """
    by_kind = {one.facts.kind: one for one in sources}
    if len(sources) > len(by_kind) or "accelerometer" not in by_kind:
        what = f"test {sources[0].test!r}: need one table of accelerometers, and at most one of gyros"
        raise DataError(what, sources[0].file, code="no_accelerometers")
    source = by_kind["accelerometer"]
    table, rests = source.table(), cast("Rests", _entry(source).rests)
    triads = {str(name): _triad(one) for name, one in by_kind.items()}
    for one in sources:
        one.chose(len(one.table()))
    direction: Array | None = None
    if rests.direction is not None:
        named = {str(axis): name for axis, name in rests.direction.items()}
        vectors = np.column_stack([table.numbers(named[axis], required=False) for axis in AXES])
        size = np.linalg.norm(vectors, axis=1)
        if np.any(size == 0.0):
            raise DataError("0, 0, 0 is no direction", table.where(int(np.argmax(size == 0.0))), code="wrong_value")
        _check_lengths(table, named, size)
        direction = np.asarray(vectors / size[:, None])
    elif rests.orientation is not None:
        direction = parse_directions(table.text(rests.orientation), source.file)
    what = f"each of the {len(table)} rows is a position: its mean readings"
    remarks = [Remark("table_of_positions", "info", what, source.file, do="For a recording, give the sample rate")]
    if not np.any(triads["accelerometer"].scatter):
        what = "no column of scatters: the noise inside positions is unknown, and taken as zero"
        remarks.append(Remark("no_scatter", "info", what, source.file, do="Name one acc_x_std, and samples"))
    # As the campaign names the file: results must not depend on where a folder lies
    where = _places(source.file, tuple(table.rows.tolist()))
    remarks_of_all = (*table.remarks, *remarks)
    return Readings(triads["accelerometer"], triads.get("gyro"), (), direction, where=where, remarks=remarks_of_all)


@lru_cache(maxsize=16)  # the same of all units of a lot
def _places(file: str, rows: tuple[int, ...]) -> tuple[str, ...]:
    return tuple([f"{file}:{row}" for row in rows])


def _check_lengths(table: Table, columns: Mapping[str, str], size: Array) -> None:
    """Refuse accelerations that were applied and are not gravity: positions have no other input.

    Raises
    ------
    DataError
        ``not_gravity``.
    """
    unit = heading(columns["x"], table.unit(columns["x"])).unit
    if unit is None or kind(unit) != "acceleration":
        return
    wrong = np.abs(size * factor(unit, "g") - 1.0) > NEAR_GRAVITY
    if not np.any(wrong):
        return
    first = int(np.argmax(wrong))
    what = f"{', '.join(columns.values())}: together {size[first]:.4g} {unit}, which is not gravity"
    raise DataError(
        what,
        table.where(first),
        "positions have no other input than gravity, whose direction these columns say",
        "Leave other rows out; what a rate table or a centrifuge applied is not read here",
        code="not_gravity",
    )


def _triad(source: Source) -> Triad:
    table, rests = source.table(), cast("Rests", _entry(source).rests)
    si = source.facts.si
    raw = kind(si) in ("count", "voltage")  # its scale factor is to be found
    reading, scatters = ({str(axis): n for axis, n in one.items()} for one in (rests.reading, rests.scatter or {}))
    # column -> its least value, and the value where it is not named
    wanted = [*((scatters.get(axis), 0.0, 0.0) for axis in AXES), (rests.samples, 1.0, 1.0)]
    own = [reading[axis] for axis in AXES]
    numbers = table.columns([*own, *(name for name, *_ in wanted if name is not None)])
    missing = ~np.isfinite(numbers[:3])
    if missing.any():
        axis, row = np.argwhere(missing)[0].tolist()
        what = f"column {own[axis]!r}: the reading of this position is missing"
        raise DataError(what, table.where(row), do="Leave the row out", code="nan_in_required")
    spread, named = np.empty((len(wanted), len(table))), [k for k, (name, *_) in enumerate(wanted) if name is not None]
    spread[:] = [[absent] for *_, absent in wanted]
    spread[named] = numbers[3:]
    small = ~(spread >= [[least] for _, least, _ in wanted])
    if small.any():
        at, row = np.argwhere(small)[0].tolist()
        name, least, _ = wanted[at]
        what = f"column {name!r}: {spread[at, row]:g}, need {least:g} or more"
        raise DataError(what, table.where(row), code="wrong_value")
    mean = convert(numbers[:3], rests.unit, si) if raw else source.all_in_si(numbers[:3], rests.unit, AXES)
    scale = np.array([factor(rests.unit, si) if raw else source.factor(rests.unit, axis) for axis in AXES])
    each = np.empty((len(table), len(AXES)))
    each[:] = spread[3][:, None]
    columns = np.ascontiguousarray(mean.T), np.ascontiguousarray((spread[:3] * scale[:, None]).T)
    return Triad(*columns, each, si, spread[3].copy())


def _oriented(readings: Readings, pairs: Sequence[Sequence[Part]]) -> Readings:
    """Return the readings with the directions that the entries give, recording after recording.

    Raises
    ------
    DataError
        ``wrong_value`` if the entries of one recording differ, or there are not as many as positions.
    """
    words: list[str] = []
    for pair in pairs:
        each = [list(said) for one in pair if (said := _entry(one.source).orientations) is not None]
        if any(one != each[0] for one in each):
            what = f"recordings {' and '.join(one.source.name for one in pair)} give different orientations"
            do = "Give them once"
            raise DataError(what, pair[0].source.file, "the unit lay in one way", do, "wrong_value")
        words += each[0] if each and each[0] != [FACES] else []
    if not words:
        return readings
    where = pairs[0][0].source.file
    found = parse_directions(words, where)
    gone = [k for k in readings.left_out if k < len(found)]
    if len(found) - len(gone) == len(readings):
        found = np.delete(found, gone, axis=0)
    if len(found) != len(readings):
        listed = ", ".join(readings.where[:12]) + (", ..." if len(readings) > 12 else "")
        what = f"{len(found)} orientations for {len(readings)} positions"
        do = 'Give one for each position, "?" where it is unknown; or plan = { shortest = ... } for other rests'
        raise DataError(what, where, f"they were found at: {listed}", do, "wrong_value")
    return replace(readings, direction=found if np.isfinite(found).any() else None)
