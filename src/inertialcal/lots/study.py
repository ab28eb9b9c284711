"""Statistics of a lot: what units scatter, whether they stay inside limits, which stations and units stand out.

A figure is the same quantity of the same test, axis and place in all units. Of a unit that was tested several times the
first test counts; the others serve the gauge. Quarantined units have no figures and are counted.

What a station shares is taken from `[standards]`: errors of standards that are not drawn anew for each unit (rate,
temperature), one draw a station. Where the uncertainty of a figure has other parts that units share, they count as the
unit's own. Where repeated tests scatter by more or less than the tests state (``understated``, ``overstated``), what is
seen counts in place of what is stated. Stations that are off, units of
another kind and tests with errors are left out of mean, scatter and capability, and counted; of yields nothing is left
out.

Findings are judged so that a lot in which nothing is wrong has a finding of each kind in at most 5 %: stations, levels
of other columns, drift, outliers, each over all figures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..campaign.engine.processes import cores
from ..core.errors import DataError
from ..core.remarks import Remark
from ..core.results import Interval, finite
from ..core.show.rounding import number, uncertainty, with_uncertainty
from ..core.show.tables import Block
from ..core.show.tables import Table as Shown
from ..statistics.population.factors import ROUNDING, Along, Level, along, levels
from ..statistics.population.gauge import Gauge, gauge
from ..statistics.population.outliers import Outliers, Uncertain, outliers
from ..statistics.population.risks import Risks, Share, risks, share
from ..statistics.population.scatter import Capability, Population, population
from .table import JUDGED, Figure, Limits, Table, Wrong

if TYPE_CHECKING:
    from pandas import DataFrame

FEW = 20  # units below which a population is a guess
FALSE = 0.05  # that a sound lot has a remark on its uncertainties, for each of both senses
LEAST_PPM = 0.01  # that a share is told by
MATTERS = 1.25  # times that an uncertainty is off from which it is remarked on
ODD_NAMED = 3  # parameters that an outlier is told by
SHOWN = 12  # lines of a list on a terminal
NOT_NORMAL = 1e-4  # probability of skewness and kurtosis from which a capability by a normal population is doubtful
THREADS = 2  # figures at a time
MOST_LEVELS = 50  # of a column that is taken for a factor


@dataclass(frozen=True)
class Columns:
    """Columns of the table of units that say where and when a unit was tested; empty where there is none."""

    station: str = ""
    place: str = ""
    factors: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class FigureStudy:
    """One figure over the lot."""

    figure: Figure
    n: int  # Units that have it
    u: float  # Standard uncertainty of one unit, median
    common: float  # Part of it that a station shares, median
    found: Population | None  # None for too few units
    stations: tuple[Level, ...]
    along: Along | None
    gauge: Gauge | None
    limits: tuple[Judged, ...] = ()


@dataclass(frozen=True, eq=False)
class Judged:
    """A figure against the limits of a requirement."""

    limits: Limits
    yields: Share  # That PASS, of the units that were judged
    failed: int
    capability: Capability | None
    risks: Risks | None


@dataclass(frozen=True, eq=False)
class Odd:
    """A unit of another kind."""

    serial: str
    distance: float  # In standard deviations
    parameters: tuple[tuple[str, float], ...]  # That stand out most: name, standard deviations
    odd_tests: int = 1  # Tests of it that say so
    tests: int = 1


@dataclass(frozen=True)
class Off:
    """A level of a column whose units read differently."""

    column: str
    level: str
    figure: Figure
    found: Level


@dataclass(frozen=True, eq=False)
class Study:
    """Statistics of a lot."""

    table: Table
    figures: tuple[FigureStudy, ...]
    passed: Share  # Units that PASS, of all
    verdicts: Mapping[str, int]
    quarantined: Mapping[str, int]  # By code
    odd: tuple[Odd, ...]
    outliers: Outliers | None
    off: tuple[Off, ...]
    drifting: tuple[FigureStudy, ...]
    columns: Columns
    stations: tuple[str, ...]
    remarks: tuple[Remark, ...] = ()

    def content(self) -> dict[str, Any]:
        """Return it as ``lot.json`` holds it."""
        return {
            "units": len(set(self.table.serials)), "tests": len(self.table),
            "passed": _share(self.passed), "verdicts": dict(self.verdicts), "quarantined": dict(self.quarantined),
            "figures": [_figure(one) for one in self.figures],
            "odd_units": [
                {"serial": one.serial, "distance": one.distance, "odd_tests": one.odd_tests, "tests": one.tests,
                 "parameters": [{"name": name, "deviation": far} for name, far in one.parameters]}
                for one in self.odd
            ],
            "wrong_tests": [
                {"serial": self.table.serials[one.row], "test": one.test, "code": one.code, "what": one.what,
                 "count": one.count}
                for one in self.table.wrong
            ],
            "off": [
                {"column": one.column, "level": one.level, "figure": one.figure.name, "test": one.figure.test,
                 "offset": one.found.offset, "u": one.found.u, "allowed": one.found.allowed, "unit": one.figure.unit,
                 "units": one.found.n, "p": one.found.p}
                for one in self.off
            ],
            "drifts": [
                {"figure": one.figure.name, "test": one.figure.test, "change": one.along.change,
                 "u": one.along.u * abs(one.along.change / one.along.slope) if one.along.slope else None,
                 "unit": one.figure.unit, "p": one.along.p}
                for one in self.drifting if one.along is not None
            ],
            "remarks": [one.to_dict() for one in self.remarks],
        }  # fmt: skip

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        from ..core.show.frames import frame  # noqa: PLC0415 - starts slowly

        rows = [_figure(one) for one in self.figures]
        names = [name for name in rows[0] if name not in ("limits", "gauge", "stations")] if rows else []
        return frame({name: [row[name] for row in rows] for name in names})

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: yields, population and capability, what stands out."""
        judged = [(one, each) for one in self.figures for each in one.limits]
        caption = f"yield: {share_text(self.passed)} of the units PASS"
        parts: list[Block] = [caption]
        if judged:
            heads = (
                "requirement",
                "figure",
                "PASS",
                "mean",
                "scatter of units",
                "u of one",
                "unit",
                "Cpk",
                "outside",
            )
            rows = [_judged_row(one, each) for one, each in judged]
            parts.append(Shown(heads, rows, "figures with limits", (2, 3, 4, 5, 7, 8)))
        lines = list(self.findings())
        parts += lines[:SHOWN] + ([f"... {len(lines) - SHOWN} more: see report.html"] if lines[SHOWN:] else [])
        return tuple(parts)

    def findings(self) -> Iterator[str]:
        """Yield what stands out, in words."""
        yield from (off_text(one) for one in self.off)
        yield from (drift_text(one) for one in self.drifting)
        yield from (wrong_text(self.table.serials[one.row], one) for one in self.table.wrong)
        yield from (odd_text(one) for one in self.odd)


def study(table: Table, columns: Columns) -> Study:
    """Return the statistics of a lot.

    Parameters
    ----------
    table : Table
        Its figures.
    columns : Columns
        What the table of units says of stations, of time, and of other places.
    """
    stations, names = table.levels(columns.station) if columns.station else (np.zeros(len(table), np.intp), ("",))
    place, _ = table.place(columns.place) if columns.place else (np.arange(len(table), dtype=float), "")
    first, far = table.first, _outliers(table, stations)
    odd_rows = _odd_rows(far, len(table))
    usable = [k for k in range(len(table.figures)) if _varies(table.values[first, k])]
    factors = {name: table.levels(name) for name in columns.factors}
    factors = {name: one for name, one in factors.items() if 1 < len(one[1]) <= MOST_LEVELS}

    def studied(k: int) -> tuple[FigureStudy, list[Off]]:
        rows = np.flatnonzero(np.isfinite(table.values[:, k]) & first & ~odd_rows)
        if rows.size < 2:
            rows = np.flatnonzero(np.isfinite(table.values[:, k]) & first)
        y, common = table.values[rows, k], float(np.median(table.common[rows, k]))
        known = np.isfinite(place[rows])
        change = along(y[known], place[rows][known], stations[rows][known], len(usable)) if known.sum() > 1 else None
        drift, in_step = 0, None
        if change is not None:  # units of a station may be early or late ones: a line is taken off, drift or not
            away = np.where(known, place[rows] - float(place[rows][known].mean()), 0.0)
            y, drift, in_step = y - change.slope * away, 1, change.u * away
        at_station = levels(y, stations[rows], common, len(usable), drift, in_step) if len(names) > 1 else []
        off = [Off(columns.station, names[one.number], table.figures[k], one) for one in at_station if one.off]
        means = {one.number: one.mean for one in at_station}
        centred = y - np.array([means.get(s, np.nan) for s in range(len(names))])[stations[rows]] if means else y
        spent = max(len(at_station) - 1, 0) + drift
        for name, (level, called) in factors.items():
            found = levels(centred, level[rows], 0.0, len(usable) * len(factors), spent)
            off += [Off(name, called[one.number], table.figures[k], one) for one in found if one.off]
        return _figure_study(table, k, rows, stations, at_station, change, odd_rows, len(usable)), off

    with ThreadPoolExecutor(min(cores(), THREADS)) as pool:
        every = list(pool.map(studied, usable))
    made, off = [one for one, _ in every], [one for _, those in every for one in those]
    drifting = tuple(one for one in made if one.along is not None and one.along.drifts)
    done = np.array([one == "done" for one in table.statuses]) & first
    words = [table.verdicts[row] for row in np.flatnonzero(done)]
    quarantined = [table.reasons[row] for row, state in enumerate(table.statuses) if state != "done"]
    everyone = len(set(table.serials))
    return Study(
        table, tuple(made), share(words.count("PASS"), everyone),
        {name: words.count(name) for name in (*JUDGED, "") if name in words},
        {code: quarantined.count(code) for code in sorted(set(quarantined))},
        tuple(_odd(table, far)), far, tuple(off), drifting, columns,
        names,
        (*_unplaced(place, columns.place, first), *_remarks(table, made, far, everyone)),
    )  # fmt: skip


def _unplaced(place: NDArray[np.float64], column: str, first: NDArray[np.bool_]) -> Iterator[Remark]:
    count = int(np.count_nonzero(first & ~np.isfinite(place)))
    if count:
        what = f"column {column}: {count} of {int(first.sum())} cells are no instant and no number"
        do = "No drift is judged of these units. Write 2026-03-12T08:00, 12.03.2026 08:00, or numbers"
        yield Remark("no_place", "warning", what, count=count, do=do)


def _varies(values: NDArray[np.float64]) -> bool:
    known = values[np.isfinite(values)]
    return known.size > 1 and float(np.ptp(known)) > ROUNDING * float(np.abs(known).max())


def _figure_study(
    table: Table, k: int, rows: NDArray[np.intp], stations: NDArray[np.intp], at_station: Sequence[Level],
    change: Along | None, odd: NDArray[np.bool_], figures: int,
) -> FigureStudy:  # fmt: skip
    bad = {one.number for one in at_station if one.off}
    kept = rows[[stations[row] not in bad for row in rows]] if bad and len(bad) < len(at_station) else rows
    common = float(np.median(table.common[rows, k]))
    repeats = np.flatnonzero(np.isfinite(table.values[:, k]) & ~odd)
    try:
        tested = gauge(
            table.values[repeats, k],
            table.own[repeats, k],
            table.own_dof[repeats, k],
            table.units[repeats],
            stations[repeats],
        )
    except DataError:
        tested = None
    own, dof = table.own[kept, k], table.own_dof[kept, k]
    if tested is not None and min(tested.excess, tested.lack) * figures < FALSE and tested.stated:
        own = own * (tested.repeatability.value / tested.stated)  # as it is seen
        dof = np.full(kept.size, tested.dof / kept.size)  # one figure for all: known as well as its repeats
    try:
        found = population(table.values[kept, k], own, dof, common, stations[kept])
    except DataError:
        found = None
    limits = tuple(_judged(table, k, one, found) for one in table.limits.get(k, ()))
    return FigureStudy(
        table.figures[k], rows.size + int(np.count_nonzero(odd & table.first & np.isfinite(table.values[:, k]))),
        float(np.median(table.u[rows, k])), common, found, tuple(at_station), change, tested, limits,
    )  # fmt: skip


def _judged(table: Table, k: int, limits: Limits, found: Population | None) -> Judged:
    rows = np.flatnonzero((limits.verdicts >= 0) & table.first)
    words = limits.verdicts[rows]
    bounded = limits.lower is not None or limits.upper is not None
    capable = found.capability(limits.lower, limits.upper) if found is not None and bounded else None
    known = rows[np.isfinite(table.values[rows, k])]
    wrong = None
    if found is not None and bounded and known.size:
        accepted = np.asarray(limits.verdicts[known] == JUDGED.index("PASS"))
        wrong = risks(table.values[known, k], table.u[known, k], accepted, found, limits.lower, limits.upper)
    passed, failed = (int(np.count_nonzero(words == JUDGED.index(word))) for word in ("PASS", "FAIL"))
    return Judged(limits, share(passed, rows.size), failed, capable, wrong)


def _outliers(table: Table, stations: NDArray[np.intp]) -> Outliers | None:
    """Return how far units lie from the rest: parameters with limits first, then those of the model."""
    parameters = [
        k
        for k, one in enumerate(table.figures)
        if k in table.limits or (one.at is None and one.parameter in table.parameters)
    ]
    order = sorted(parameters, key=lambda k: k not in table.limits)
    if not order:
        return None
    usual = np.column_stack([table.usual(k) for k in order])
    uncertain = Uncertain(table.own[:, order], table.own_dof[:, order], table.common[:, order], stations, usual)
    with ThreadPoolExecutor(min(cores(), THREADS)) as pool:
        found = outliers(table.values[:, order], table.first, uncertain, pool.map)
    return Outliers(np.array(order, dtype=np.intp)[found.used], found.logarithm, found.distance, found.limit,
                    found.outlier, found.deviation, found.heavy)  # fmt: skip


def _odd_rows(far: Outliers | None, n: int) -> NDArray[np.bool_]:
    return np.zeros(n, dtype=bool) if far is None else far.outlier


def _odd(table: Table, far: Outliers | None) -> Iterator[Odd]:
    """Yield each unit of another kind, by the test of it that lies farthest off."""
    rows: dict[int, list[int]] = {}
    for row in np.flatnonzero(_odd_rows(far, len(table))).tolist():
        rows.setdefault(int(table.units[row]), []).append(row)
    for unit, every in rows.items():
        assert far is not None  # noqa: S101 - it named the rows
        row = max(every, key=lambda one: far.distance[one])
        own = far.deviation[row]
        order = np.argsort(-np.abs(np.nan_to_num(own)))[:ODD_NAMED]
        told = tuple((table.figures[far.used[j]].name, float(own[j])) for j in order if np.isfinite(own[j]))
        of = int(np.count_nonzero(table.units == unit))
        yield Odd(table.serials[row], float(far.distance[row]), told, len(every), of)


def _remarks(table: Table, made: Sequence[FigureStudy], far: Outliers | None, everyone: int) -> list[Remark]:
    found = []
    if everyone < FEW:
        what = f"{everyone} units: what the population scatters is hardly known"
        found.append(Remark("few_units", "warning", what, do=f"{FEW} or more tell"))
    most = max((one.n for one in made), default=0)
    kept = [one for one in made if 2 * one.n > most]  # others are there where a test chose so by what it saw
    over = [
        one
        for one in kept
        if _overstated(one) * len(made) < FALSE and (one.gauge is None or (one.gauge.ratio.hi or 0.0) < 1.0 / MATTERS)
    ]
    if over:
        what = f"{_names(over)}: figures scatter less than their uncertainties allow: these are stated too large"
        do = "Look for parts of the uncertainty that all units share, for terms that a test chooses by itself " \
             "(a plan that says 'auto'), or for copied recordings"  # fmt: skip
        found.append(Remark("overstated", "warning", what, count=len(over), do=do))
    under = [
        one
        for one in kept
        if one.gauge is not None and one.gauge.excess * len(made) < FALSE and (one.gauge.ratio.lo or 0.0) > MATTERS
    ]
    if under:
        what = f"{_names(under)}: repeated tests scatter more than their uncertainties state"
        do = "Find what is not in the uncertainty: mounting, power-up, the operator"
        found.append(Remark("understated", "warning", what, count=len(under), do=do))
    odd = [one for one in made if one.limits and one.found is not None and one.found.normal_p < NOT_NORMAL]
    if odd:
        what = f"{_names(odd)}: the units are not normal: Cpk and conforming share are those of a normal population"
        found.append(Remark("not_normal", "warning", what, count=len(odd), do="Go by the yield"))
    wanders = [one for one in made if one.along is not None and one.along.wanders]
    if wanders:
        what = f"{_names(wanders)}: the mean wanders along the lot"
        found.append(Remark("wanders", "warning", what, count=len(wanders), do="See where, in report.html"))
    if far is not None and far.heavy:
        what = "parameters have heavier tails than normal ones: some units are called odd that are of the same kind"
        found.append(Remark("heavy_tails", "warning", what, do="Look at the farthest first"))
    if not any(one.gauge is not None for one in made):
        do = "Test some units again, at each station: a row a test in the table of units"
        what = "too few units were tested again: the scatter of the tests is what they state, not what was seen"
        found.append(Remark("no_repeats", "info", what, do=do))
    return found


def _overstated(one: FigureStudy) -> float:
    """Return the probability that so little scatter would be seen if the tests stated theirs rightly."""
    if one.gauge is not None:
        return one.gauge.lack
    return 1.0 if one.found is None else one.found.excess


def _names(studies: Sequence[FigureStudy]) -> str:
    names = [f"{one.figure.test}: {one.figure.name}" for one in studies[:ODD_NAMED]]
    more = len(studies) - len(names)
    return ", ".join(names) + (f" and {more} more" if more else "")


# ---- words ----------------------------------------------------------------------------------------------------------


def share_text(one: Share) -> str:
    """Return a share with its interval, in percent."""
    low, high = (100.0 * (end or 0.0) for end in (one.interval.lo, one.interval.hi))
    return f"{one.count} of {one.of} ({100.0 * one.value:.1f} %, {low:.1f} to {high:.1f} %)"


def capability_text(one: Capability | None) -> str:
    """Return a capability index with its interval."""
    if one is None:
        return "-"
    low, high = one.cpk_interval.lo, one.cpk_interval.hi
    if high is None or not math.isfinite(one.cpk):
        return f"above {low:.2f}" if low is not None and math.isfinite(low) else "no scatter seen"
    return f"{one.cpk:.2f} ({low:.2f} to {high:.2f})"


def scatter_text(one: Population | None) -> str:
    """Return the scatter of a population with its interval."""
    if one is None:
        return "-"
    low, high = (float(end or 0.0) for end in (one.scatter_interval.lo, one.scatter_interval.hi))
    if not one.seen:
        return f"below {uncertainty(high)}" if high else "not seen"
    return f"{number(one.scatter, 3)} ({number(low, 3)} to {number(high, 3)})"


def conforming_text(one: Capability | None) -> str:
    """Return the share of the population outside, 95 %, in parts per million."""
    if one is None:
        return "-"
    ends = (1e6 * (1.0 - float(end or 0.0)) for end in (one.conforming_interval.hi, one.conforming_interval.lo))
    low, high = (_plain_number(end) for end in ends)
    return f"{low} to {high} ppm" if high != "0" else f"below {LEAST_PPM:g} ppm"


def _plain_number(value: float) -> str:
    """Return a number with two digits and no power of ten; 0 for one that is too small to tell."""
    if value < LEAST_PPM:
        return "0"
    return number(value, 2) if value < 99.5 else f"{float(f'{value:.1e}'):,.0f}"


def mean_text(one: Population | None) -> str:
    """Return the mean of a population with its uncertainty."""
    return "-" if one is None else with_uncertainty(one.mean, one.mean_u)


def _judged_row(one: FigureStudy, each: Judged) -> list[str]:
    return [
        each.limits.requirement, one.figure.name, f"{each.yields.count}/{each.yields.of}", mean_text(one.found),
        scatter_text(one.found), uncertainty(one.u), one.figure.unit, capability_text(each.capability),
        conforming_text(each.capability),
    ]  # fmt: skip


def level_text(one: Off) -> str:
    """Say by how much a level reads differently."""
    sense = "more" if one.found.offset > 0.0 else "less"
    return f"{with_uncertainty(abs(one.found.offset), one.found.u)} {one.figure.unit} {sense} than the others"


def off_text(one: Off) -> str:
    """Say which level is off."""
    times = number(abs(one.found.offset) / one.found.allowed, 2)
    what = f"{one.column} {one.level}: {one.figure.test} {one.figure.name} reads {level_text(one)}"
    return f"{what}, {times} times what its standards and units allow"


def drift_text(one: FigureStudy) -> str:
    """Say what drifts."""
    found = one.along
    assert found is not None  # noqa: S101 - it drifts
    u = found.u * abs(found.change / found.slope) if found.slope else 0.0
    change = with_uncertainty(found.change, u)
    return f"along the lot: {one.figure.test} {one.figure.name} changes by {change} {one.figure.unit}"


def wrong_text(serial: str, one: Wrong) -> str:
    """Say what is wrong with a test of a unit."""
    more = f" (and {one.count - 1} more)" if one.count > 1 else ""
    return f"unit {serial}: {one.test + ': ' if one.test else ''}{one.what}{more}"


def odd_text(one: Odd) -> str:
    """Say which unit is odd."""
    told = ", ".join(f"{name} {deviation:+.1f}" for name, deviation in one.parameters)
    some = f" in {one.odd_tests} of its {one.tests} tests" if one.odd_tests < one.tests else ""
    far = f"{number(one.distance, 2)} standard deviations off"
    return f"unit {one.serial} is of another kind{some}, {far}: {told}"


# ---- as JSON --------------------------------------------------------------------------------------------------------


def _interval(one: Interval) -> dict[str, Any]:
    return {"lo": finite(one.lo), "hi": finite(one.hi), "p": one.p}


def _share(one: Share) -> dict[str, Any]:
    return {"count": one.count, "of": one.of, "interval": _interval(one.interval)}


def _figure(one: FigureStudy) -> dict[str, Any]:
    figure, found = one.figure, one.found
    named = {name: getattr(figure, name) for name in ("test", "quantity", "axis", "sensor", "power", "at", "at_unit",
                                                      "condition", "unit")}  # fmt: skip
    of_population: dict[str, Any] = dict.fromkeys(
        ("mean", "mean_u", "mean_dof", "observed", "scatter", "scatter_interval", "between_stations", "normal_p")
    )
    if found is not None:
        of_population |= {
            "mean": found.mean, "mean_u": found.mean_u, "mean_dof": finite(found.mean_dof), "observed": found.observed,
            "scatter": found.scatter if found.seen else None, "scatter_interval": _interval(found.scatter_interval),
            "between_stations": found.between, "normal_p": finite(found.normal_p),
        }  # fmt: skip
    return named | {"n": one.n, "u": one.u, "u_common": one.common} | of_population | {
        "limits": [_limits(each) for each in one.limits],
        "gauge": None if one.gauge is None else _gauge(one.gauge),
    }  # fmt: skip


def _limits(one: Judged) -> dict[str, Any]:
    capable, wrong = one.capability, one.risks
    return {
        "requirement": one.limits.requirement, "lower": one.limits.lower, "upper": one.limits.upper,
        "passed": _share(one.yields), "failed": one.failed,
        "cpk": None if capable is None else finite(capable.cpk),
        "cpk_interval": None if capable is None else _interval(capable.cpk_interval),
        "cp": None if capable is None else finite(capable.cp),
        "conforming": None if capable is None else capable.conforming,
        "conforming_interval": None if capable is None else _interval(capable.conforming_interval),
        "accepted_outside": None if wrong is None else
        {"expected": wrong.consumer.expected, "interval": _interval(wrong.consumer.interval)},
        "rejected_inside": None if wrong is None else
        {"expected": wrong.producer.expected, "interval": _interval(wrong.producer.interval)},
    }  # fmt: skip


def _gauge(one: Gauge) -> dict[str, Any]:
    def size(name: str) -> dict[str, Any] | None:
        found = getattr(one, name)
        return None if found is None else {"value": found.value, "interval": _interval(found.interval)}

    return {
        "units": one.units, "tests": one.tests, "stations": one.stations, "crossed": one.crossed,
        "repeatability": size("repeatability"), "reproducibility": size("reproducibility"), "gauge": size("gauge"),
        "part": one.part, "distinct": one.distinct, "stated": one.stated, "ratio": _interval(one.ratio),
    }  # fmt: skip
