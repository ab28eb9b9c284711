"""Readings of a flip: from a table of reduced means, or from recordings with the positions of the head."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.times import read_elapsed, read_instant
from ...core.units import convert, factor, kind, si_unit
from ...core.unknowns import joined
from ...files.text.table import read_table
from ..corrections import between, corrected
from ..protocol import Correction, Source
from .dwells.disturbances import is_reading, stamped
from .dwells.quiet import Window
from .dwells.recordings import FlipRecording, readings_from
from .entry import Dwells, FlipEntry, Means, Position
from .plan import Plan
from .readings import HalfWidths, Readings


@dataclass(frozen=True)
class MeanOf:
    """One mean of a table.

    Parameters
    ----------
    axis : str
        That reads.
    angle : float
        Position [rad].
    mean : float
        [m/s^2].
    flip : str
        Which flip.
    half_widths : tuple of (float, float)
        Probability and half width [m/s^2] of each t-interval that is given.
    temperature : float
        [degC]; NaN where not given.
    others : mapping of str to float
        The same by other statistics [m/s^2].
    dwell : str
        Tells dwells of one flip and position apart; empty where there is one.
    time : float
        Middle of the dwell [s]; NaN where not given.
    where : str
        File and row.
    predicted : float
        Bias that a ground model predicts in the dwell [m/s^2]; NaN where not given.
    """

    axis: str
    angle: float
    mean: float
    flip: str = "1"
    half_widths: tuple[tuple[float, float], ...] = ()
    temperature: float = math.nan
    others: Mapping[str, float] | None = None
    dwell: str = ""
    time: float = math.nan
    where: str = ""
    predicted: float = math.nan


def readings_of_means_tables(sources: Sequence[Source]) -> Readings:
    """Return the readings of tables of reduced means.

    Raises
    ------
    DataError
        ``nothing_left`` if no row is in the groups of the test; as `means_of`.
    """
    used: list[MeanOf] = []
    remarks: list[Remark] = []
    for source in sources:
        table, means = source.table(), cast("FlipEntry", source.entry).means
        assert means is not None  # noqa: S101 - as the file was checked
        rows = means_of(source, means)
        chosen = [one for one in rows if source.groups is None or one.flip in source.groups]
        source.chose(len(chosen))
        used += chosen
        remarks += [*table.remarks, *table.missing(means.mean)]
    if not used:
        what = f"test {sources[0].test!r}: no row is in its groups ({', '.join(sources[0].groups or ())})"
        raise DataError(what, code="nothing_left")
    readings = readings_of_means(used)
    return replace(readings, remarks=(*remarks, *readings.remarks))


def means_of(source: Source, means: Means) -> list[MeanOf]:
    """Return the means of a table, a row each, SI: counts and volts through the chain of their axis.

    Raises
    ------
    DataError
        If a column is missing, a position has no angle (``wrong_value``), an axis is none of x, y, z, or the unit of
        a prediction beside counts or volts is not stated (``no_unit``).
    """
    table, file = source.table(), source.file
    axes, positions = table.text(means.axis), table.text(means.position)
    flips = table.text(means.flip) if means.flip else ("1",) * len(table)
    warm = table.numbers(means.temperature) if means.temperature else [math.nan] * len(table)
    predicted: Array = np.full(len(table), math.nan)
    if means.predicted is not None:  # in the unit of its header, else that of the means
        own = table.unit(means.predicted)
        unit = own if own is not None and kind(own) == "acceleration" else means.unit
        if kind(unit) != "acceleration":
            what, do = f"column {means.predicted!r}: unit not stated", f"Write it in its header: {means.predicted} [ug]"
            raise DataError(what, file, "the means are in counts or volts, a predicted bias is none", do, "no_unit")
        predicted = table.numbers(means.predicted) * factor(unit, si_unit(unit))
    given, lowered = table.numbers(means.mean), [one.lower() for one in axes]
    values, scale = np.full(len(table), math.nan), np.full(len(table), math.nan)
    for axis in dict.fromkeys(lowered):
        own_rows = np.array([one == axis for one in lowered])
        if axis in AXES:
            values[own_rows] = source.in_si(np.where(own_rows, given, math.nan), means.unit, axis)[own_rows]
            scale[own_rows] = abs(source.factor(means.unit, axis))
    widths = {float(p): table.numbers(column, required=False) * scale for p, column in means.half_widths.items()}
    rows = []
    for i, row in enumerate(table.rows):
        where = f"{file}:{row}"
        if positions[i] not in means.angles:
            what = f"column {means.position!r}: position {positions[i]!r} has no angle"
            raise DataError(what, where, do=f"means.angles has: {', '.join(means.angles)}", code="wrong_value")
        halves = tuple((p, float(width[i])) for p, width in widths.items() if math.isfinite(width[i]))
        angle, temperature = means.angles[positions[i]], float(warm[i])
        rows.append(MeanOf(lowered[i], angle, float(values[i]), flips[i], halves, temperature,
                           where=where, predicted=float(predicted[i])))  # fmt: skip
    return rows


def turned_head(source: Source) -> FlipRecording:
    """Return a recording with the windows of its entry.

    Raises
    ------
    DataError
        ``wrong_time`` if a time is not on the clock of the recording.
    """
    entry = cast("FlipEntry", source.entry)
    recording = stamped(source.recordings()[0][1])
    begin = None if entry.clock is None else entry.clock.mission_start
    origin = None if begin is None else read_instant(begin)
    positions = entry.positions or () if entry.dwells is None else positions_of_table(source, entry.dwells)
    return FlipRecording(recording, windows_of(positions, recording, source.name, origin), source.name)


def positions_of_table(source: Source, dwells: Dwells) -> list[Position]:
    """Return the positions that a table of dwells says.

    Raises
    ------
    DataError
        ``nan_in_required`` if an angle is missing; ``no_dwells`` if no row is a dwell.
    """
    table = source.read_file(dwells.file, read_table)
    angle = convert(table.numbers(dwells.angle), dwells.unit, "rad")
    flips = table.text(dwells.flip) if dwells.flip else ("1",) * len(table)
    kept = table.text(dwells.dwell) if dwells.dwell else ("1",) * len(table)
    rows = zip(kept, table.text(dwells.start), table.text(dwells.stop), angle, flips, strict=True)
    found = []
    for i, (dwell, start, stop, turned, flip) in enumerate(rows):
        if not dwell:
            continue
        if not math.isfinite(turned):
            what = f"column {dwells.angle!r}: no angle"
            raise DataError(what, table.where(i), do="Fill it in", code="nan_in_required")
        found.append(Position.model_construct(start=start, stop=stop, angle=float(turned), flip=flip))
    if not found:
        raise DataError("no row is a dwell", dwells.file, do="Number its dwells", code="no_dwells")
    return found


def corrected_heads(plan: Plan, turned: Sequence[FlipRecording], corrections: Sequence[Correction]) -> Readings:
    """Return the dwells of recordings after what earlier tests found, and what is not known of it in each dwell.

    Raises
    ------
    DataError
        As the corrections, and `readings_from`.
    """
    made = corrected(corrections, [(one.name, one.recording) for one in turned])[0]
    readings = readings_from(plan, [replace(one, recording=r) for one, r in zip(turned, made, strict=True)])
    cut: list[tuple[str, Recording] | None] = [None] * len(readings)
    for one, quiet in zip(turned, readings.quiet, strict=True):
        for k in np.flatnonzero(quiet.dwells):
            start, stop = (int(one.time_ns[0] + round(float(at) * SECOND)) for at in quiet.spans[k])
            cut[k] = one.name, between(one.recording, start, stop)
    parts = corrected(corrections, [one for one in cut if one is not None])[1]
    return replace(readings, taken_off=joined(parts, [1] * len(parts)))


def windows_of(
    given: Sequence[Position], recording: Recording, name: str, origin: int | None = None
) -> tuple[Window, ...]:
    """Return windows on the clock of their recording.

    Parameters
    ----------
    given : sequence of Position
        As an entry has them.
    recording : Recording
        Whose clock.
    name : str
        Of the recording.
    origin : int, optional
        Zero of mission elapsed time [ns].

    Raises
    ------
    DataError
        ``wrong_time`` if a time is not on that clock.
    """

    def instant(text: Any) -> int:
        try:
            return read_instant(text, origin) if recording.epoch == "utc" else read_elapsed(text)
        except ValueError as error:
            clock = "UTC" if recording.epoch == "utc" else "elapsed time, without a date"
            why = f"the clock of {recording.source.path or name} is {clock}"
            raise DataError(f"recordings.{name}.positions: {error}", why=why, code="wrong_time") from None

    return tuple(Window(instant(one.start), instant(one.stop), one.angle, one.flip) for one in given)


def readings_of_means(means: Sequence[MeanOf]) -> Readings:
    """Return the dwells of a table of means.

    Raises
    ------
    DataError
        If there is none, an axis is unknown (``wrong_value``), a position is not finite (``wrong_value``), a mean is
        beyond any accelerometer (``wrong_value``), or an axis stands twice in a dwell (``repeated_row``).
    """
    if not means:
        raise DataError("no dwells", why="there is nothing to separate", code="no_dwells")
    groups: dict[tuple[str, str, float], dict[str, MeanOf]] = {}
    for one in means:
        _check(one)
        dwell = groups.setdefault((one.flip, one.dwell, one.angle), {})
        if one.axis in dwell:
            what = f"axis {one.axis} stands twice at {math.degrees(one.angle):.6g} deg of flip {one.flip}"
            do = "Name the dwell, where a position is repeated within a flip"
            raise DataError(what, one.where, f"the first is {dwell[one.axis].where or 'above'}", do, "repeated_row")
        dwell[one.axis] = one
    return _pivoted(list(groups), list(groups.values()))


def _check(one: MeanOf) -> None:
    if one.axis not in AXES:
        raise DataError(f"axis {one.axis!r}", one.where, do="Need x, y or z", code="wrong_value")
    if not math.isfinite(one.angle):
        raise DataError(f"position {one.angle}", one.where, do="Need the turn from position 0", code="wrong_value")
    numbers = {"mean": one.mean, "predicted bias": one.predicted} | {f"half width {p:g}": w for p, w in one.half_widths}
    for name, value in {**numbers, **dict(one.others or {})}.items():
        if not is_reading(value):
            what = f"{name} of {one.axis} is {value:.3g} m/s^2, too large for an accelerometer"
            raise DataError(what, one.where, do="Mend the number, or its unit", code="wrong_value")


def _pivoted(keys: list[tuple[str, str, float]], dwells: list[dict[str, MeanOf]]) -> Readings:
    every = [one for dwell in dwells for one in dwell.values()]
    axes = [axis for axis in AXES if any(one.axis == axis for one in every)]

    def table(value: Callable[..., float | None], *key: object) -> dict[str, Array]:
        rows = {axis: [value(dwell[axis], *key) if axis in dwell else None for dwell in dwells] for axis in axes}
        return {axis: np.array(values, dtype=np.float64) for axis, values in rows.items()}

    given = [[one.time for one in dwell.values() if math.isfinite(one.time)] for dwell in dwells]
    time = np.array([float(np.mean(own)) if own else math.nan for own in given])
    names = dict.fromkeys(name for one in every for name in one.others or {})
    probabilities = sorted({p for one in every for p, _ in one.half_widths})
    return Readings(
        angle=np.array([angle for _, _, angle in keys]),
        flip=np.array([flip for flip, _, _ in keys]),
        outputs=table(lambda one: one.mean),
        others={name: table(lambda one, name: (one.others or {}).get(name), name) for name in names},
        half_widths=tuple(HalfWidths(p, table(lambda one, p: dict(one.half_widths).get(p), p)) for p in probabilities),
        time=time if np.isfinite(time).any() else None,
        temperature=_known(table(lambda one: one.temperature)),
        predicted=_known(table(lambda one: one.predicted)),
        where=tuple(next(iter(dwell.values())).where for dwell in dwells) if any(one.where for one in every) else (),
    )


def _known(values: Mapping[str, Array]) -> dict[str, Array]:
    return {axis: one for axis, one in values.items() if np.isfinite(one).any()}
