"""History of a unit: what each figure was from test to test, its drift with uncertainty, when it leaves a limit.

A series is one figure over the campaigns of a unit: alike in quantity, axis, place, method and condition, and in the
name of the test where a campaign has several such. Its drift is that of ``statistics.over_time.drift_line``. The word
``drift`` needs a t test at 95 %, with Holm's step-down over the figures of one quantity of one test [1]_: where nothing
drifts, it falls in at most 5 % of histories of each quantity.

A unit that ages along a curve, jumps, or has a test that is not its own (another unit's serial number, another unit of
measure) has no line: what departs from it is named in place of ``drift``, with Holm's step-down over all figures of the
unit, and nothing is forecast. Adjustments that are stated part a series into stretches, each with its own level and
all with one slope. A figure that is that of a campaign added before to the last digit is a copy of it, and is left out.

When to calibrate again is told by the control of drift and uncertainty, the family of statistical methods that
ILAC-G24 [2]_ names: the line and its prediction interval are followed until the change since the last test may exceed
the stated limit. That date has an interval of its own: from where the 95 % interval first touches the limit, to where
it lies wholly outside.

References
----------
.. [1] Holm, Scandinavian J. Statistics 6 (1979) 65-70.
.. [2] ILAC-G24:2022 / OIML D 10, Guidelines for the determination of recalibration intervals of measuring equipment.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from sqlalchemy import Connection, select

from ..campaign.compare.allowed_change import allowed_for, parse_allowed
from ..core.errors import DataError, UsageError
from ..core.key import Method
from ..core.remarks import Remark
from ..core.results import Interval, Row, finite
from ..core.show.result_tables import remarks_line
from ..core.show.rounding import number, settled, settled_ends
from ..core.show.rows import quantity_name
from ..core.show.tables import Block, Table, html, text
from ..core.times import LATEST, instant_text, read_instant
from ..core.units import divide, same_dimension
from ..statistics.decision import holm
from ..statistics.intervals import t_interval, t_quantile
from ..statistics.over_time.drift_line import REJECTED, Due, Kind, Line, due, line
from .drawn import content_of_history
from .points import Point, in_unit, points
from .tables import items, results

if TYPE_CHECKING:
    from pandas import DataFrame

YEAR = 31_557_600.0  # [s]: 365.25 days
DATE = len("2024-05-04")
HORIZON = 30.0  # [years] to which forecasts look
P = 0.95
Word = Literal["drift", "no drift shown", "bends", "jumps", "odd test", ""]
DEPARTURES: dict[Kind, Word] = {"bend": "bends", "jump": "jumps", "odd": "odd test"}
DIGITS = 7  # of a figure, from which an equal one is no chance
HEADS = ("figure", "test", "tests", "last", "unit")
OF_DRIFT = ("drift a year", "95 % interval", "verdict")


@dataclass(frozen=True, eq=False)
class Series:
    """One figure of a unit over time."""

    points: tuple[Point, ...]  # By time
    line: Line | None  # Through them, time in years since the first; None of one test
    drift: Row | None  # A year, with its interval
    word: Word
    limit: float | None = None  # Of a change since the last test, where one is stated
    due: Due | None = None  # In years since the last test
    since: int = 0  # The first point after the last adjustment

    @property
    def straight(self) -> bool:
        """Whether nothing shows that it is no line."""
        return self.word not in DEPARTURES.values()

    @property
    def last(self) -> Point:
        """The newest."""
        return self.points[-1]

    def years(self, time_ns: int) -> float:
        """Return an instant in years since the first test."""
        return (time_ns - (self.points[0].time_ns or 0)) / 1e9 / YEAR

    def date(self, after: float | None) -> int | None:
        """Return the instant so many years after the last test [ns]; None for none, or one beyond 2100."""
        if after is None or self.last.time_ns is None:
            return None
        found = self.last.time_ns + round(after * YEAR * 1e9)
        return found if found < LATEST * 10**9 else None

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        found: dict[str, Any] = {
            "tests": [
                {"campaign": one.campaign, "name": one.name, "test": one.row.test, "time_ns": one.time_ns,
                 "value": one.row.value, "u": one.row.u, "dof": finite(one.row.dof), "unit": one.row.unit}
                for one in self.points
            ],
            "drift": None if self.drift is None else self.drift.to_dict(),
            "word": self.word,
        }  # fmt: skip
        if self.line is not None:
            found |= {"wander": self.line.wander, "consistency": self.line.consistency, "basis": self.line.basis,
                      "p_value": self.line.p_value}  # fmt: skip
            found["departure"] = None if self.line.departure is None else asdict(self.line.departure)
        if self.due is not None:
            dates = {name: self.date(getattr(self.due, name)) for name in ("first", "expected", "last")}
            found |= {"limit": self.limit, "due": {name: None if at is None else instant_text(at)
                                                   for name, at in dates.items()}}  # fmt: skip
        return found


@dataclass(frozen=True, eq=False)
class History:
    """All figures of a unit."""

    item: dict[str, str]
    series: tuple[Series, ...]
    remarks: tuple[Remark, ...] = field(default=())

    @property
    def due_ns(self) -> int | None:
        """The instant by which the unit is to be calibrated again; None where no limit is stated, or none is near."""
        dates = [at for one in self.series if one.due is not None and (at := one.date(one.due.first)) is not None]
        return min(dates, default=None)

    @property
    def results(self) -> list[dict[str, Any]]:
        """Drifts as rows of results."""
        return [one.drift.to_dict() for one in self.series if one.drift is not None]

    def content(self) -> dict[str, Any]:
        """Return what figures are drawn from, as ``inertialcal.plot`` takes it."""
        return content_of_history(self.series)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a figure, when the unit is due, how many remarks."""
        heads = (*HEADS, *(OF_DRIFT if self._drifts else ()), *(("limit", "due") if self._limited else ()))
        rows = [self._cells(one) for one in self.series]
        unit = " ".join(filter(None, (self.item["maker"], self.item["part"], self.item["serial"])))
        parts: list[Block] = [Table(heads, rows, f"history of {unit}", (2, 3, 5))]
        if self.due_ns is not None:
            parts.append(f"calibrate again by {instant_text(self.due_ns)[:10]}")
        return (*parts, *remarks_line(self.remarks))

    @property
    def _drifts(self) -> bool:
        return any(one.drift is not None for one in self.series)

    @property
    def _limited(self) -> bool:
        return any(one.limit is not None for one in self.series)

    def _cells(self, one: Series) -> list[str]:
        row, drift = one.last.row, one.drift
        name = f"{quantity_name(row.to_dict())} {row.axis}".strip() + (f" at {row.key.at}" if row.key.at else "")
        cells = [name, row.test, str(len(one.points)), settled(row.value, row.u), row.unit]
        if one.straight and drift is not None and drift.interval is not None:
            ends = settled_ends(drift.value, drift.u, drift.interval.lo, drift.interval.hi)
            cells += [settled(drift.value, drift.u), ends, one.word]
        elif self._drifts:
            cells += ["-", "", one.word]
        if one.due is not None:
            at = one.date(one.due.first)
            when = f"not in {HORIZON:g} years" if at is None else instant_text(at)[:10]
            cells += [f"± {number(one.limit, 4)}", when]
        elif self._limited:
            cells += ["", ""] if one.limit is None else [f"± {number(one.limit, 4)}", "no line"]
        return cells

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure of a test."""
        from ..core.show.frames import frame  # noqa: PLC0415 - starts slowly

        every = [(one, point) for one in self.series for point in one.points]
        columns = {
            "quantity": [point.row.quantity for _, point in every], "axis": [point.row.axis for _, point in every],
            "test": [point.row.test for _, point in every], "campaign": [point.name for _, point in every],
            "time_ns": [point.time_ns for _, point in every], "value": [point.row.value for _, point in every],
            "u": [point.row.u for _, point in every], "unit": [point.row.unit for _, point in every],
        }  # fmt: skip
        return frame(columns)


def history(
    connection: Connection,
    serial: str,
    part: str | None = None,
    quantity: str | None = None,
    axis: str | None = None,
    test: str | None = None,
    limits: Sequence[str] = (),
    adjusted: Sequence[str] = (),
) -> History:
    """Return the history of a unit.

    Parameters
    ----------
    connection : Connection
        That reads.
    serial, part : str
        Of the unit; the part where several units have the serial number.
    quantity, axis, test : str, optional
        Of these alone.
    limits : sequence of str
        How far a figure may change since its last test: ``"0.01 deg/s"``, ``"scale_factor_error=0.1 %"``.
    adjusted : sequence of str
        Days of adjustments, ``"2024-05-04"``, or instants: tests of that day are after it ("as left").

    Raises
    ------
    DataError
        ``no_item``; ``no_figure``; ``unit_mismatch`` of a limit; as ``read_instant``.
    UsageError
        ``several_items``; ``allowed``.
    """
    stated = parse_allowed(limits)
    instants = sorted(read_instant(f"{day}T00:00:00Z" if len(day) == DATE else day) for day in adjusted)
    item = _item(connection, serial, part)
    conditions = [items.c.id == item["id"]]
    conditions += [results.c.quantity == quantity] if quantity else []
    conditions += [results.c.axis == axis] if axis else []
    conditions += [results.c.test == test] if test else []
    every = points(connection, *conditions)
    timed = [one for one in every if one.time_ns is not None]
    if not every:
        wanted = " ".join(filter(None, (quantity, axis, test)))
        what = f"no figure{f' of {wanted}' * bool(wanted)} of unit {serial!r} has an uncertainty"
        raise DataError(what, do=f"See: inertialcal archive history {serial}", code="no_figure")
    grouped, copies = without_copies(series_of(timed))
    made = []
    for found in grouped:
        unit = found[-1].row.unit
        figures = in_unit(found, unit)
        start = found[0].time_ns or 0
        years = [((one.time_ns or 0) - start) / 1e9 / YEAR for one in found]
        stretches = [sum(at <= (one.time_ns or 0) for at in instants) for one in found]
        fitted = _line(years, figures, stretches)
        row = None if fitted is None else _drift(found[-1].row, fitted)
        limit = allowed_for(found[-1].row, stated) if stated else None
        when = None if fitted is None or limit is None else due(fitted, years[-1], figures[-1].value, limit, HORIZON)
        made.append(Series(tuple(found), fitted, row, "", limit, when, stretches.index(stretches[-1])))
    judged = _judged(made)
    apart = len(timed) - sum(len(one) for one in grouped) - sum(copies.values())
    remarks = _remarks(judged, len(every) - len(timed), apart, copies)
    return History({name: str(item[name]) for name in ("maker", "part", "serial", "owner")}, tuple(judged),
                   tuple(remarks))  # fmt: skip


def _item(connection: Connection, serial: str, part: str | None) -> dict[str, Any]:
    query = select(items).where(items.c.serial == serial)
    found = [dict(one) for one in connection.execute(query).mappings() if part in (None, one["part"])]
    if not found:
        do = "See: inertialcal archive list"
        raise DataError(f"no unit of serial number {serial!r} in the archive", do=do, code="no_item")
    if len(found) > 1:
        parts = ", ".join(dict.fromkeys(repr(one["part"]) for one in found))
        what = f"{len(found)} units have serial number {serial!r}"
        raise UsageError(what, do=f"Say of which part; there are: {parts}", code="several_items")
    return found[0]


def series_of(found: Sequence[Point]) -> list[list[Point]]:
    """Return points grouped by what they are of, those of one dimension together."""
    groups: dict[Hashable, list[Point]] = {}
    for one in found:
        groups.setdefault(_figure(one.row), []).append(one)
    made: list[list[Point]] = []
    for group in groups.values():
        alone = len({one.campaign for one in group}) == len(group)
        apart: dict[str, list[Point]] = {}
        for one in group:
            apart.setdefault("" if alone else one.row.test, []).append(one)
        for each in apart.values():
            unit = each[-1].row.unit
            made.append([one for one in each if same_dimension(one.row.unit, unit)])
    return made


def without_copies(series: Sequence[Sequence[Point]]) -> tuple[list[list[Point]], dict[tuple[str, str], int]]:
    """Return series without figures that a campaign has from another; how many, by it and that which had them first.

    Parameters
    ----------
    series : sequence of sequence of Point
        Of one unit.
    """
    kept, copies = [], dict[tuple[str, str], int]()
    for found in series:
        first: dict[tuple[float, float], Point] = {}
        for one in sorted(found, key=lambda point: point.campaign):
            same = first.setdefault((one.found.value, one.found.u), one)
            if same is not one and _exact(one):
                copies[one.name, same.name] = copies.get((one.name, same.name), 0) + 1
        own = {id(one) for one in first.values()}
        kept.append([one for one in found if id(one) in own or not _exact(one)])
    return kept, copies


def _exact(one: Point) -> bool:
    """Whether a figure has so many digits that an equal one is a copy."""
    return len(f"{one.found.value:.11e}".partition("e")[0].strip("-").rstrip("0")) > DIGITS


def _figure(row: Row) -> Hashable:
    """Return what a figure is of; a place as tables show it."""
    place = None if row.key.at is None else str(row.key.at)
    return row.key._replace(at=None), place, row.condition


def _line(years: Sequence[float], figures: Sequence[Any], stretches: Sequence[int]) -> Line | None:
    try:
        return line(years, figures, stretches)
    except DataError:  # one test, or one day
        return None


def _drift(row: Row, found: Line) -> Row:
    unit = divide(row.unit, "year")
    return Row(
        row.key, found.slope, found.u, unit, finite(found.dof), t_interval(found.slope, found.u, found.dof, P),
        test=row.test, condition=row.condition, method=Method.DRIFT,
    )  # fmt: skip


def _judged(made: Sequence[Series]) -> list[Series]:
    """Return the series, each with the word on its drift, and without a forecast where it is no line."""
    departures = [(i, found) for i, one in enumerate(made) if one.line is not None and (found := one.line.departure)]
    words: dict[int, Word] = {}
    for (i, found), rejected in zip(departures, holm([one.p_value for _, one in departures], 1.0 - P), strict=True):
        if rejected:
            words[i] = DEPARTURES[found.kind]
    families: dict[Hashable, list[int]] = {}
    for i, one in enumerate(made):
        if one.line is not None and i not in words:
            row = one.last.row
            families.setdefault((row.test, row.key.sensor, row.quantity), []).append(i)
    for family in families.values():
        p_values = [fitted.p_value for i in family if (fitted := made[i].line) is not None]
        for i, rejected in zip(family, holm(p_values, 1.0 - P), strict=True):
            words[i] = "drift" if rejected else "no drift shown"
    judged = [replace(one, word=words.get(i, "")) for i, one in enumerate(made)]
    return [one if one.straight else replace(one, due=None) for one in judged]


def _departed(one: Series) -> Iterator[Remark]:
    """Yield what is said of a series that is no line."""
    found = None if one.line is None else one.line.departure
    if one.straight or found is None:
        return
    row, (before, at) = one.last.row, (one.points[max(found.index - 1, 0)], one.points[found.index])
    name = f"{quantity_name(row.to_dict())} {row.axis}".strip() + f", {row.test}"
    size = f"{number(found.size, 3)} {row.unit}".strip()
    day, day_before = (instant_text(point.time_ns or 0)[:10] for point in (at, before))
    unit = "Check that its serial number and its units of measure are right"
    said = {
        "bend": (f"ages along a curve, up to {size} off a line: there is no drift a year to tell, and no forecast",
                 "Look at it with -o history.png; test it more often"),
        "jump": (f"jumps by {size} between {day_before} and {day}: no forecast",
                 f"If it was adjusted then: --adjusted {day}. {unit}"),
        "odd": (f"campaign {at.name} of {day} is {size} off the line through the others: no forecast", unit),
    }  # fmt: skip
    what, do = said[found.kind]
    yield Remark(one.word.replace(" ", "_"), "warning", what, where=name, do=do)


def _remarks(made: Sequence[Series], untimed: int, apart: int, copies: Mapping[tuple[str, str], int]) -> list[Remark]:
    found = []
    if untimed:
        what = "figures of tests whose day is not known: they stand in no history"
        found.append(Remark("no_time", "warning", what, count=untimed, do='State day = "2026-11-29" in [[tests]]'))
    if apart:
        what = "figures in units of another kind than the last test has: they stand in no history"
        found.append(Remark("other_dimension", "warning", what, count=apart, do="Correct unit in their campaigns"))
    for (copy, first), count in copies.items():
        what = f"figures are those of campaign {first} to the last digit: copies, and left out"
        found.append(Remark("copied", "warning", what, where=copy, count=count, do="Run it with its own recordings"))
    found += [remark for one in made for remark in _departed(one)]
    two = [one for one in made if one.line is not None and one.line.basis == "difference"]
    if two:
        what = "two tests: u is that of their difference, and a wander of the unit is not in it"
        found.append(Remark("two_tests", "info", what, count=len(two)))
    lines = [one for one in made if one.straight and one.line is not None]
    odd = [one for one in lines if (fit := one.line) and fit.wander and fit.consistency < REJECTED]
    if odd:
        names = ", ".join(dict.fromkeys(f"{one.last.row.quantity} {one.last.row.axis}".strip() for one in odd[:6]))
        what = f"scatters about its line more than the stated uncertainties say, which is in u: {names}"
        found.append(Remark("wanders", "info", what, count=len(odd)))
    return found


def forecast(one: Series, time_ns: int) -> tuple[float, Interval] | None:
    """Return what a figure is expected to be at an instant, with its 95 % interval; None of one test."""
    if one.line is None:
        return None
    value, u = one.line.at(one.years(time_ns))
    half = u * t_quantile(one.line.dof, 0.5 + 0.5 * P) if math.isfinite(u) else math.inf
    return value, Interval(value - half, value + half, P)
