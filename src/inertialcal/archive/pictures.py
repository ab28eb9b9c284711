"""History and trend as pictures, for ``report``."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from ..core.show.rounding import number, with_uncertainty
from ..core.show.rows import quantity_name
from ..report.figures.archive import history as drawn_history
from ..report.figures.archive import trend as drawn_trend
from ..report.figures.drawing.picture import Picture
from ..statistics.intervals import t_quantile
from .history import YEAR, History, Series
from .trend import Group, Trend

AHEAD = 2.0  # years that a line goes beyond the last test
POINTS = 60  # of a line
HALF = 0.975


def history_pictures(found: History) -> list[Picture]:
    """Return a picture of each figure that has a drift; of all where none has."""
    chosen = [one for one in found.series if one.line is not None] or list(found.series)
    return [drawn_history.picture(_history(one)) for one in chosen]


def _history(one: Series) -> drawn_history.Drawn:
    row = one.last.row
    what = f"{quantity_name(row.to_dict())} {row.axis}".strip().replace("_", " ")
    start = datetime.fromtimestamp((one.points[0].time_ns or 0) / 1e9, UTC)
    first = start.year + (start - datetime(start.year, 1, 1, tzinfo=UTC)).total_seconds() / YEAR
    years = np.array([one.years(point.time_ns or 0) for point in one.points])
    values = np.array([point.figure.value for point in one.points])
    half = np.array([point.figure.u * t_quantile(point.figure.dof, HALF) for point in one.points])
    line = one.line if one.straight else None
    line_years = np.zeros(0) if line is None else np.linspace(years[one.since], years[-1] + AHEAD, POINTS)
    at = np.zeros((0, 2)) if line is None else np.array([line.at(float(year)) for year in line_years])
    factor = 1.0 if line is None else t_quantile(line.dof, HALF)
    drift = one.drift
    said = "" if drift is None else f": {with_uncertainty(drift.value, drift.u)} {drift.unit}, {one.word}"
    said = said if one.straight else f": {one.word}, no line"
    limits = None if one.limit is None else (values[-1] - one.limit, values[-1] + one.limit)
    return drawn_history.Drawn(what, row.unit, f"{what}{said}", first + years, values, half, first + line_years,
                               at[:, 0], at[:, 1] * factor, limits)  # fmt: skip


def trend_pictures(found: Trend) -> list[Picture]:
    """Return a picture of each chart."""
    names = [one.name for one in found.groups]
    return [drawn_trend.picture(_trend(one, names.count(one.name) > 1)) for one in found.groups]


def _trend(one: Group, several: bool) -> drawn_trend.Drawn:
    """Return what is drawn of a chart, with its test where several charts are of one figure."""
    chart, test = one.chart, one.points[-1].row.test
    n, what = len(one.signals), one.name.replace("_", " ")
    name = f"{what}, {test}" if several else what
    state = "in control" if not n else f"{n} signal{'s' * (n > 1)}"
    finding = f"{name}: mean {number(chart.centre, 4)} {one.unit}, {state} in {len(one.labels)} {one.by}s"
    return drawn_trend.Drawn(what, one.unit, finding, one.by, chart.values, chart.centre, chart.lower, chart.upper,
                             chart.out | chart.in_run | chart.spread_out, chart.spread, chart.spread_lower,
                             chart.spread_upper)  # fmt: skip
