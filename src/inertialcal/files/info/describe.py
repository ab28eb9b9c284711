"""Description of each column: axis, quantity, unit; a unit said by flag goes before that of the file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core import units
from ...core.batches import any_step, batches, every
from ...core.errors import DataError, UsageError
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ...core.unit.atoms import REFUSED
from ...signals.time.time_axis import AGAIN, TimeAxis, backward_steps
from ..columns import Column
from ..text.headers import (
    KINDS,
    THREES,
    Heading,
    about_axis,
    bare_name,
    counted_axis,
    heading_within,
    is_applied,
    normal_unit,
)

GROUPS = {
    "gyro": "gyro",
    "gyr": "gyro",
    "acc": "acc",
    "accel": "acc",
    "mag": "magnetometer",
    "magnetometer": "magnetometer",
    "temp": "temperature",
    "temperature": "temperature",
    "pressure": "pressure",
    "voltage": "voltage",
    "time": "time",
}
OF_AXES = ("gyro", "acc", "magnetometer")  # quantities of which a matrix of three columns is x, y, z
READINGS = {"gyro": "angular_rate", "acc": "acceleration"}  # kind of unit of the readings of a sensor
TESTED = ("voltage", "count")  # kinds of unit that a built-in test may be recorded in
Said = tuple[str, str | None, str | None]  # name of a column, unit of its header, unit that the caller says
COUNTED_FROM = 3  # rows from which 0, 1, 2, ... is a count of rows


@dataclass(frozen=True, eq=False)
class Described:
    """A column with what is known of it."""

    column: Column  # As read
    axis: str  # As ``Heading`` has them
    quantity: str  # As ``Heading`` has them
    unit: str | None  # As ``core.units`` prints it
    unit_from: str  # ``"flag"``, ``"header"``, ``"format"`` or ``""``

    @property
    def name(self) -> str:
        """Name in the file."""
        return self.column.name


def describe(
    columns: Sequence[Column], flags: Mapping[str, str], path: str
) -> tuple[tuple[Described, ...], tuple[Remark, ...]]:
    """Return each column with its quantity and unit.

    Parameters
    ----------
    columns : sequence of Column
        As read.
    flags : mapping of str to str
        Unit by column (name, name without the unit in brackets, or number counted from 1) or by group
        (``gyro``, ``acc``, ``mag``, ``temp``, ``pressure``, ``voltage``, ``time``).
    path : str
        File, for messages.

    Raises
    ------
    UsageError
        If a flag names no column or group, or its unit does not fit the quantity.
    DataError
        If its unit is not known.
    """
    remarks: list[Remark] = []
    described = [_from_header(column, path, remarks) for column in columns]
    described = _turned(_readings_alone(_one_a_letter(_counted_axes(_letters_first(described)))))
    said: list[Said] = []
    by_group = {key: unit for key, unit in flags.items() if not _named(described, key)}
    by_column = {key: unit for key, unit in flags.items() if key not in by_group}
    for key, unit in (*by_group.items(), *by_column.items()):  # a column goes before its group
        chosen = _chosen(described, key)
        if key in by_group:  # the rate of a table, which has no axis, keeps the unit of its header
            chosen = [i for i in chosen if described[i].unit is None or described[i].axis] or chosen
        for i in chosen:
            before, described[i] = described[i], _with_flag(described[i], unit)
            said.append((before.name, before.unit, described[i].unit))
    return tuple(described), (*remarks, *overridden(said, path))


def find_column(described: Sequence[Described], key: str, path: str) -> int:
    """Position of a column by name, name without unit, or number counted from 1.

    Raises
    ------
    DataError
        If there is none; the message lists those there are.
    """
    found = _named(described, key)
    if len(found) == 1:
        return found[0]
    raise DataError(
        f"no column {key!r}",
        where=path,
        do=f"The file has: {', '.join(d.name for d in described) or 'none'}",
        code="wrong_column",
    )


def _from_header(column: Column, path: str, remarks: list[Remark]) -> Described:
    """Return what name and metadata say."""
    title = column.name if column.named else column.matrix
    said = heading_within(title, column.unit, column.matrix) if title or column.unit else Heading()
    if said.unknown:
        cause, do = REFUSED.get(said.unknown, ("", ""))
        what = f"{said.unknown!r} in the header of {column.name!r} is not a suitable unit: ignored"
        what += f" ({cause})" if cause else ""
        remarks.append(Remark("unknown_unit", "info", what, where=path, do=do, subject=column.name))
    quantity = "index" if _counts_rows(column, said.quantity) else said.quantity
    kept = quantity != "index" and (quantity != "status" or said.unit is None or units.kind(said.unit) in TESTED)
    unit = said.unit if kept else None
    axis = said.axis or (column.axis if quantity in OF_AXES else "")
    return Described(column, axis, quantity, unit, "header" if unit else "")


def _counted_axes(described: Sequence[Described]) -> list[Described]:
    """Return the columns; three of a sensor that are counted 0, 1, 2 (``gyroADC[0]``) are its x, y and z."""
    found, named = list(described), [counted_axis(one.name) for one in described]
    for stem in {stem for stem, _ in named if stem}:
        own = [i for i, (other, _) in enumerate(named) if other == stem]
        if len(own) == 3 and all(found[i].quantity in OF_AXES and not found[i].axis for i in own):
            for i in own:
                found[i] = replace(found[i], axis=named[i][1])
    return found


def _letters_first(described: Sequence[Described]) -> list[Described]:
    """Return the columns; where letters name the axes of the gyros (``GyroZ``), words beside (``Yaw Rate``) do not."""
    by_word = {i for i, one in enumerate(described) if one.quantity == "gyro" and one.axis and about_axis(one.name)}
    lettered = any(one.quantity == "gyro" and one.axis for i, one in enumerate(described) if i not in by_word)
    return [replace(one, axis="") if lettered and i in by_word else one for i, one in enumerate(described)]


def _one_a_letter(described: Sequence[Described]) -> list[Described]:
    """Return the columns; three of a sensor by their unit whose names differ in one letter are its x, y and z."""
    found = list(described)
    for quantity, kind in READINGS.items():
        own = [one for one in found if one.quantity == quantity and one.unit and units.kind(one.unit) == kind]
        bare = {bare_name(one.name).lower(): one for one in own}
        for name, letters in ((name, letters) for name in bare for letters in THREES):
            for at in (at for at in range(len(name)) if name[at] == letters[0]):
                three = [bare.get(name[:at] + letter + name[at + 1 :]) for letter in letters]
                if all(one is not None and not one.axis for one in three):
                    for axis, one in zip("xyz", three, strict=True):
                        found = [replace(other, axis=axis) if other is one else other for other in found]
    return found


def _readings_alone(described: Sequence[Described]) -> list[Described]:
    """Return the columns; those beside a triad that are about its sensor (``gyro_clipping``) are no readings."""
    found = list(described)
    for quantity, kind in READINGS.items():
        own = [one for one in described if one.quantity == quantity]
        if {one.axis for one in own} >= {"x", "y", "z"}:
            aside = [i for i, one in enumerate(found) if one in own and not one.axis]
            for i in aside:
                if found[i].unit is None or units.kind(found[i].unit or "") != kind:
                    found[i] = replace(found[i], quantity="")
    return found


def _turned(described: Sequence[Described]) -> list[Described]:
    """Return the columns; beside the rate of a table, columns of counts or volts that are axes alone are of gyros."""
    rates = [one for one in described if one.quantity == "gyro" and not one.axis and one.unit]
    sensors = any(one.axis and one.quantity in READINGS for one in described)
    if sensors or not any(units.kind(one.unit or "") == "angular_rate" for one in rates):
        return list(described)
    raw = [one.axis and not one.quantity and one.unit and units.kind(one.unit) in TESTED for one in described]
    return [replace(one, quantity="gyro") if own else one for one, own in zip(described, raw, strict=True)]


def _counts_rows(column: Column, quantity: str) -> bool:
    """Whether a column without a meaning holds 0, 1, 2, ... or 1, 2, 3, ..."""
    if quantity or not column.is_number or len(column.values) < COUNTED_FROM or not column.is_complete:
        return False
    first = column.values[0]
    if first not in (0, 1):
        return False
    return all(np.array_equal(column.values[a:b], first + np.arange(a, b)) for a, b in batches(column.values))


def _named(described: Sequence[Described], key: str) -> list[int]:
    """Columns of a name; by number where there is none."""
    exact = [i for i, d in enumerate(described) if d.name == key]
    bare = exact or [i for i, d in enumerate(described) if bare_name(d.name) == key]
    if bare or not (key.isascii() and key.isdigit() and len(key) < 6):
        return bare
    return [int(key) - 1] if 1 <= int(key) <= len(described) else []


def _chosen(described: Sequence[Described], key: str) -> list[int]:
    """Columns that a flag means."""
    named = _named(described, key)
    group = GROUPS.get(key.lower())
    readings = [i for i, d in enumerate(described) if not (d.unit and d.axis and is_applied(d.name))]
    chosen = named or [i for i in readings if group and described[i].quantity == group]
    if not chosen:  # an axis, of the one sensor that has it
        of_axis = [i for i, d in enumerate(described) if d.axis == key]
        chosen = of_axis if len(of_axis) == 1 else []
    if not named and len(chosen) > 1 and chosen[0] == 0 and _runs_like_time(described[0].column):
        chosen = chosen[1:]  # a matrix is called after its sensor, and its first column is the clock
    if not chosen:
        names = ", ".join(d.name for d in described)
        groups = sorted({d.quantity for d in described if d.quantity in KINDS})
        raise UsageError(
            f"no column or group {key!r} to apply the unit to",
            do=f"Columns: {names}." + (f" Groups: {', '.join(groups)}" if groups else ""),
            code="wrong_column",
        )
    return chosen


def _runs_like_time(column: Column) -> bool:
    """Whether a column without a name of its own can be the time of the others: it always increases, in fractions."""
    if column.named or not column.is_number or not column.is_complete or len(column.values) < COUNTED_FROM:
        return False
    if any_step(column.values, lambda step: ~(step > 0)):
        return False
    return not every(column.values, lambda part: np.all(part == np.rint(part)))


def _with_flag(described: Described, text: str) -> Described:
    """Return the column with the unit of a flag."""
    unit, quantity = normal_unit(text, described.quantity), described.quantity
    kind = units.kind(unit)
    if quantity in KINDS and kind not in KINDS[quantity]:
        raise UsageError(
            f"{unit} measures {kind.replace('_', ' ')}, column {described.name!r} is {quantity}",
            do="Name the column itself, or another unit",
            code="unit_mismatch",
        )
    return replace(described, unit=unit, unit_from="flag")


def overridden(said: Iterable[Said], path: str) -> tuple[Remark, ...]:
    """Return remarks on columns whose header states another unit than the caller, whose word holds.

    Parameters
    ----------
    said : iterable of Said
        Name, unit of the header, unit that the caller says.
    path : str
        File, for messages.

    Raises
    ------
    UsageError
        ``unit_mismatch`` for volts and counts that are said to be a rate or an acceleration.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for name, header, unit in said:
        if unit is None or header in (None, unit):
            continue
        if is_raw(header, unit):
            raise UsageError(
                f"{name!r} is in {header} by its header: another unit makes no {unit} of it",
                where=path,
                why="counts and volts become readings by the scale factor of the sensor",
                do="Leave the unit out; a test takes --scale-factor, of the data sheet, and --reference, what it gives "
                "without input",
                code="unit_mismatch",
            )
        alike.setdefault((str(header), unit), []).append(name)
    found = []
    for (header, unit), names in alike.items():
        are, their = ("is", "its") if len(names) == 1 else ("are", "their")
        what = f"{', '.join(map(repr, names))} {are} {header} by {their} header, {unit} by the option: the option wins"
        do = f"If the header is right, leave {unit} out"
        found.append(Remark("unit_overridden", "warning", what, where=path, do=do))
    return tuple(found)


def is_raw(header: str | None, unit: str) -> bool:
    """Whether a column in counts or volts by its header is said to be in a unit of rate or acceleration."""
    return header is not None and units.kind(header) in TESTED and units.kind(unit) in READINGS.values()


RATES_AGREE = 0.01  # relative difference of two sample rates that is passed over
RESTARTS = 10  # samples of a first recording
WRONG_BY = 1.5  # ratio from which one of them is wrong


def axis_remarks(axis: TimeAxis, time_ns: Times, row: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return what a user should know about the stamps.

    Parameters
    ----------
    axis : TimeAxis
        Judged stamps.
    time_ns : ndarray of int64, shape (n,)
        The stamps [ns].
    row : callable
        Gives ``file:row`` of a sample.
    """
    remarks = []
    if len(axis.repeated):
        remarks.append(_counted("repeated_stamps", "repeated time stamp", axis.repeated, row))
    if len(axis.backward):
        near = 2.0 * (axis.interval or 0.0) * SECOND
        again = axis.backward[(np.abs(time_ns[axis.backward] - time_ns[0]) <= near) & (axis.backward >= RESTARTS)]
        others = np.setdiff1d(axis.backward, again)
        if len(again):
            what = f"{backward_steps(time_ns, again)}, its beginning: a second recording in the same file?"
            do = "Split the file there"
            remarks.append(replace(_counted("time_backwards", what, again, row), do=do))
        if len(others):
            remark = _counted("time_backwards", backward_steps(time_ns, others), others, row)
            remarks.append(replace(remark, do=AGAIN))
    if axis.pattern == "bursts" and axis.interval is not None:
        what = (
            f"time stamps come in bursts: steps of {_si(axis.median_step)} (median) up to "
            f"{_si(axis.longest_step)}, {_si(axis.interval)} on average, used as the sample interval"
        )
        do = "If the sensor samples evenly, give its rate: --sample-rate"
        remarks.append(Remark("stamps_in_bursts", "warning", what, where=row(0), do=do))
    if len(axis.gaps) and axis.interval is not None:
        longest = float(axis.gaps.length.max())
        steps = ", ".join(f"{_si(step)} x{count}" for step, count in axis.steps[:6])
        what = (
            f"gap: {axis.lost} sample(s) missing in all, longest step {_si(longest)} "
            f"against {_si(axis.interval)} (steps: {steps})"
        )
        where = row(int(axis.gaps.after[0]))
        remarks.append(Remark("gaps", "warning", what, where=where, count=len(axis.gaps)))
    return tuple(remarks)


def rate_remark(given: float, rates: Mapping[str, float], path: str, from_header: bool = False) -> tuple[Remark, ...]:
    """Return a remark where a sample rate that was given disagrees with all that the file says.

    Parameters
    ----------
    given : float
        Sample rate by option or campaign [Hz].
    rates : mapping of str to float
        What the file says [Hz], by words: ``"the time stamps say"``.
    path : str
        File.
    from_header : bool
        Whether the rate that counts stands in the file, not in an option.
    """
    if not rates or any(abs(rate - given) <= RATES_AGREE * rate for rate in rates.values()):
        return ()
    far = all(max(rate / given, given / rate) >= WRONG_BY for rate in rates.values())
    said = f"{given:.6g} Hz by the header" if from_header else f"{given:.6g} Hz was given"
    what = ", ".join((said, *(f"{words} {rate:.6g} Hz" for words, rate in rates.items())))
    do = "Check the rate, and the unit of time: --unit COLUMN=UNIT"
    return (Remark("sample_rate_disagrees", "error" if far else "warning", what, where=path, do=do),)


def _counted(code: str, what: str, at: np.ndarray[tuple[int], np.dtype[np.int64]], row: Callable[[int], str]) -> Remark:
    return Remark(code, "warning", what, where=row(int(at[0])), count=len(at))


def _si(seconds: float) -> str:
    """Time with a fitting unit."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= size:
            return f"{seconds / size:.4g} {unit}"
    return f"{seconds / 1e-9:.4g} ns"
