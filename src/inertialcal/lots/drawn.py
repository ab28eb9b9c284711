"""A lot as curves, which figures are drawn from: those with limits, and those in which something stands out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..core.curve import Column, Curve
from ..core.estimate import Array
from ..core.show.rounding import number
from .study import (
    FigureStudy,
    Study,
    capability_text,
    drift_text,
    level_text,
    scatter_text,
)

BINS = 30
POINTS = 121  # of a population's curve
WIDE = 4.0  # standard deviations that it is drawn over
BLOCKS = 40  # along a lot
THIN = 2_000  # units of a figure of distances, and all that are of another kind
OFF_NAMED = 2  # levels that a title names
MIDDLE = (0.05, 0.95)


def content_of_lot(found: Study) -> dict[str, Any]:
    """Return what figures of a lot are drawn from."""
    off = {(one.figure.test, one.figure.name) for one in found.off}
    drifts = {(one.figure.test, one.figure.name) for one in found.drifting}
    made: list[Mapping[str, Any]] = []
    for one in found.figures:
        key = (one.figure.test, one.figure.name)
        if one.limits or key in off or key in drifts:
            made += _distribution(found, one)
            made += _stations(found, one)
            made += _along(found, one)
    made += _distances(found)
    return {"results": [], "curves": made}


def _known(found: Study, one: FigureStudy) -> tuple[np.ndarray[Any, Any], Array]:
    k = found.table.figures.index(one.figure)
    rows = np.flatnonzero(np.isfinite(found.table.values[:, k]) & found.table.first)
    return rows, found.table.values[rows, k]


def _distribution(found: Study, one: FigureStudy) -> list[Mapping[str, Any]]:
    _, y = _known(found, one)
    ends = [end for each in one.limits for end in (each.limits.lower, each.limits.upper) if end is not None]
    middle, width = float(np.median(y)), 1.4826 * float(np.median(np.abs(y - np.median(y)))) or float(np.ptp(y))
    inside = y[np.abs(y - middle) <= 8.0 * width] if width else y  # a unit far off would make one bar of all others
    count, edges = np.histogram(inside, BINS)
    unit = one.figure.unit
    lower, upper = (np.full(BINS, np.nan) for _ in range(2))
    for each in one.limits:
        for column, end in ((lower, each.limits.lower), (upper, each.limits.upper)):
            if end is not None:
                column[0] = end
    beyond = y.size - inside.size
    said = f"; {beyond} beyond" if beyond else ""
    capable = [f"Cpk {capability_text(each.capability)}, " for each in one.limits if each.capability is not None]
    finding = f"{one.figure.test}, {one.figure.name}: {''.join(capable[:1])}units scatter {_scatter(one)} {unit}{said}"
    columns = {"from": Column(edges[:-1], unit), "to": Column(edges[1:], unit), "units": Column(count.astype(float)),
               "lower": Column(lower, unit), "upper": Column(upper, unit)}  # fmt: skip
    made = [_curve("lot_distribution", one, columns, finding)]
    population = one.found
    if population is not None and population.seen:
        s = population.scatter
        x = np.linspace(population.mean - WIDE * s, population.mean + WIDE * s, POINTS)
        if ends:
            x = np.union1d(x, [end for end in ends if abs(end - population.mean) < WIDE * s])
        bar = float(edges[1] - edges[0]) * y.size
        density = bar * np.exp(-0.5 * ((x - population.mean) / s) ** 2) / (s * np.sqrt(2.0 * np.pi))
        made.append(_curve("lot_population", one, {"value": Column(x, unit), "units": Column(density)}))
    return made


def _scatter(one: FigureStudy) -> str:
    """Return what the units scatter: without its interval where a capability has one already."""
    if one.found is None or not one.found.seen or not one.limits:
        return scatter_text(one.found)
    return number(one.found.scatter, 3)


def _stations(found: Study, one: FigureStudy) -> list[Mapping[str, Any]]:
    if len(one.stations) < 2:
        return []
    off = [each for each in found.off if each.figure == one.figure and each.column == found.columns.station]
    unit = one.figure.unit
    what = f"{one.figure.test}, {one.figure.name}"
    named = [f"{found.columns.station} {each.level} reads {level_text(each)}" for each in off[:OFF_NAMED]]
    more = f", {len(off) - OFF_NAMED} more" if len(off) > OFF_NAMED else ""
    finding = f"{what}: {', '.join(named)}{more}" if off else f"{what}: no {found.columns.station} is off"
    columns = {
        "level": Column([found.stations[each.number] for each in one.stations]),
        "units": Column(np.array([float(each.n) for each in one.stations])),
        "offset": Column(np.array([each.offset for each in one.stations]), unit),
        "u": Column(np.array([each.u for each in one.stations]), unit),
        "allowed": Column(np.array([each.allowed for each in one.stations]), unit),
        "off": Column(np.array([each.off for each in one.stations])),
    }
    return [_curve("lot_stations", one, columns, finding)]


def _along(found: Study, one: FigureStudy) -> list[Mapping[str, Any]]:
    if one.along is None:
        return []
    rows, y = _known(found, one)
    if found.columns.place:
        place, unit = found.table.place(found.columns.place)
        x = place[rows]
    else:
        x, unit = rows.astype(np.float64), "unit"
    known = np.isfinite(x)
    order = np.argsort(x[known], kind="stable")
    x, y = x[known][order], y[known][order]
    x = x - x[0] if unit == "day" else x
    blocks = np.array_split(np.arange(x.size), min(BLOCKS, max(x.size // 5, 1)))
    mean = np.array([y[b].mean() for b in blocks])
    u = np.array([y[b].std(ddof=1) / np.sqrt(b.size) if b.size > 1 else np.nan for b in blocks])
    low, high = (np.array([np.quantile(y[b], q) for b in blocks]) for q in MIDDLE)
    own = one.figure.unit
    what = f"{one.figure.test}, {one.figure.name}"
    if one in found.drifting:
        finding = drift_text(one)
    else:
        finding = f"{what}: the mean wanders along the lot" if one.along.wanders else f"{what}: no drift along the lot"
    columns = {"place": Column(np.array([x[b].mean() for b in blocks]), unit), "mean": Column(mean, own),
               "u": Column(u, own), "low": Column(low, own), "high": Column(high, own)}  # fmt: skip
    return [_curve("lot_along", one, columns, finding)]


def _distances(found: Study) -> list[Mapping[str, Any]]:
    far = found.outliers
    if far is None or not far.used.size:
        return []
    known = np.flatnonzero(np.isfinite(far.distance))
    if not known.size:
        return []
    keep = known[:: max(1, known.size // THIN)]
    keep = np.union1d(keep, known[far.outlier[known]])
    n, units = len(found.odd), np.unique(found.table.units[known]).size
    by = f"by {far.used.size} parameters together"
    finding = f"{n} of {units} units {'is' if n == 1 else 'are'} of another kind, {by}" if n else \
              f"no unit is of another kind, {by}"  # fmt: skip
    columns = {"number": Column(keep.astype(float) + 1.0), "distance": Column(far.distance[keep]),
               "limit": Column(np.full(keep.size, far.limit)), "odd": Column(far.outlier[keep])}  # fmt: skip
    return [Curve("lot_distance", "", columns).to_dict() | {"finding": finding}]


def _curve(name: str, one: FigureStudy, columns: Mapping[str, Column], finding: str = "") -> Mapping[str, Any]:
    figure = one.figure
    made = Curve(name, figure.axis, columns, figure.name).to_dict(figure.test)
    return made | {"condition": figure.condition} | ({"finding": finding} if finding else {})


__all__ = ["content_of_lot"]
