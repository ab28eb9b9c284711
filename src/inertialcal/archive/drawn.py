"""History and trend as curves, which figures are drawn from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.curve import Column, Curve
from ..core.show.rounding import number, with_uncertainty
from ..core.show.rows import quantity_name
from ..statistics.intervals import t_quantile
from .points import in_unit

if TYPE_CHECKING:
    from .history import Series
    from .trend import Group

AHEAD = 2.0  # years that a line goes beyond the last test
POINTS = 60  # of a line
HALF = 0.975


def content_of_history(series: Sequence[Series]) -> dict[str, Any]:
    """Return what figures of a unit are drawn from, first those that drift or are no line.

    Parameters
    ----------
    series : sequence of Series
        Of one unit; those of several tests are drawn, all where none has several.
    """
    chosen = [one for one in series if one.line is not None] or list(series)
    chosen.sort(key=lambda one: one.word in ("no drift shown", ""))
    return {"results": [], "curves": [curve for one in chosen for curve in _of_series(one)]}


def _of_series(one: Series) -> list[Mapping[str, Any]]:
    row = one.last.row
    what = _name(row.to_dict(), row.axis, "" if row.key.at is None else str(row.key.at))
    start = datetime.fromtimestamp((one.points[0].time_ns or 0) / 1e9, UTC)
    begin, end = (datetime(start.year + i, 1, 1, tzinfo=UTC) for i in (0, 1))
    first = start.year + (start - begin) / (end - begin)
    years = np.array([one.years(point.time_ns or 0) for point in one.points])
    figures = in_unit(one.points, row.unit)
    values = np.array([figure.value for figure in figures])
    half = np.array([figure.u * t_quantile(figure.dof, HALF) for figure in figures])
    columns = {"year": Column(first + years), "value": Column(values, row.unit), "half": Column(half, row.unit)}
    if one.limit is not None:
        ends = {"low": values[-1] - one.limit, "high": values[-1] + one.limit}
        columns |= {name: Column(np.full(years.size, end), row.unit) for name, end in ends.items()}
    said = f": {one.word}, no line"
    if one.straight:
        drift = one.drift
        said = "" if drift is None else f": {with_uncertainty(drift.value, drift.u)} {drift.unit}, {one.word}"
    made: list[Mapping[str, Any]] = [
        Curve("archive_history", row.axis, columns, what).to_dict(row.test)
        | {"condition": row.condition, "finding": f"{what}{said}"}
    ]
    if one.line is not None and one.straight:
        along = np.linspace(years[one.since], years[-1] + AHEAD, POINTS)
        at = np.array([one.line.at(float(year)) for year in along])
        line = {"year": Column(first + along), "value": Column(at[:, 0], row.unit),
                "half": Column(at[:, 1] * t_quantile(one.line.dof, HALF), row.unit)}  # fmt: skip
        made.append(Curve("archive_line", row.axis, line, what).to_dict(row.test) | {"condition": row.condition})
    return made


def content_of_trend(groups: Sequence[Group]) -> dict[str, Any]:
    """Return what charts are drawn from.

    Parameters
    ----------
    groups : sequence of Group
        Each is a chart.
    """
    names = [one.name for one in groups]
    return {"results": [], "curves": [_of_group(one, names.count(one.name) > 1) for one in groups]}


def _of_group(one: Group, several: bool) -> dict[str, Any]:
    """Return the curve of a chart, with its test where several charts are of one figure."""
    chart, row = one.chart, one.points[-1].row
    n, what = len(one.signals), one.name.replace("_", " ")
    name = f"{what}, {row.test}" if several else what
    state = "in control" if not n else f"{n} signal{'s' * (n > 1)}"
    finding = f"{name}: mean {number(chart.centre, 4)} {one.unit}, {state} in {len(one.labels)} {one.by}s"
    columns = {
        one.by: Column(one.labels), "value": Column(chart.values, one.unit),
        "mean": Column(np.full(chart.values.size, chart.centre), one.unit), "lower": Column(chart.lower, one.unit),
        "upper": Column(chart.upper, one.unit), "signal": Column(chart.out | chart.in_run | chart.spread_out),
        "spread": Column(chart.spread, one.unit), "spread_lower": Column(chart.spread_lower, one.unit),
        "spread_upper": Column(chart.spread_upper, one.unit),
    }  # fmt: skip
    return Curve("archive_trend", row.axis, columns, what).to_dict(row.test) | {"finding": finding}


def _name(row: Mapping[str, Any], axis: str, at: str) -> str:
    return (f"{quantity_name(row)} {axis}".strip() + (f" at {at}" if at else "")).replace("_", " ")
