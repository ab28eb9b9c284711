"""Trend of a quantity over all units, in order of time, as a control chart: single figures, or means of lots.

Of each unit the last test counts, or with `every` each test. Figures of one axis, place, condition and name of a test
are one chart. Limits hold the uncertainty of the tests, and what they share by their standards
(``statistics.over_time.control_charts``).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Literal

from sqlalchemy import Connection

from ..core.errors import DataError
from ..core.key import At
from ..core.remarks import Remark
from ..core.results import finite
from ..core.show.result_tables import remarks_line
from ..core.show.rounding import number
from ..core.show.rows import quantity_name
from ..core.show.tables import Block, Table, html, text
from ..core.units import same_dimension
from ..statistics.over_time.control_charts import RUN, Chart, individuals, lots
from .drawn import content_of_trend
from .points import Point, in_unit, points
from .tables import items, results

if TYPE_CHECKING:
    from pandas import DataFrame

By = Literal["unit", "lot"]
KIND = ("at_what", "at_value", "at_unit", "quantity", "axis", "sensor", "power", "test", "condition")
FEW = 20  # points below which limits are themselves uncertain
HEADS = ("figure", "test", "points", "mean", "limits", "unit", "from unit to unit", "signals")


@dataclass(frozen=True, eq=False)
class Group:
    """One chart."""

    by: By
    points: tuple[Point, ...]  # In order of time
    chart: Chart
    labels: tuple[str, ...]  # Of the values of the chart: serial numbers, or lots
    unit: str

    @property
    def name(self) -> str:
        """What it is of, in words."""
        row = self.points[-1].row
        return f"{quantity_name(row.to_dict())} {row.axis}".strip() + (f" at {row.key.at}" if row.key.at else "")

    @property
    def signals(self) -> list[tuple[str, str]]:
        """Label and kind of each signal: ``beyond``, ``run``, ``spread``."""
        chart = self.chart
        kinds = {"beyond": chart.out, "run": chart.in_run, "spread": chart.spread_out}
        return [(label, kind) for i, label in enumerate(self.labels) for kind, there in kinds.items() if there[i]]

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        chart, row = self.chart, self.points[-1].row
        columns = {"value": chart.values, "lower": chart.lower, "upper": chart.upper, "spread": chart.spread,
                   "spread_lower": chart.spread_lower, "spread_upper": chart.spread_upper}  # fmt: skip
        return {
            "quantity": row.quantity, "axis": row.axis, "test": row.test, "condition": row.condition, "by": self.by,
            "unit": self.unit, "mean": chart.centre, "process": chart.process, "in_control": chart.in_control,
            "signals": [{"label": label, "kind": kind} for label, kind in self.signals],
            "points": [{"label": label} | {name: finite(float(column[i])) for name, column in columns.items()}
                       for i, label in enumerate(self.labels)],
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Trend:
    """A quantity over all units."""

    quantity: str
    groups: tuple[Group, ...]
    remarks: tuple[Remark, ...] = ()

    def content(self) -> dict[str, Any]:
        """Return what figures are drawn from, as ``inertialcal.plot`` takes it."""
        return content_of_trend(self.groups)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a chart, then its signals."""
        rows = []
        for one in self.groups:
            chart = one.chart
            low, high = float(chart.lower[-1]), float(chart.upper[-1])
            rows.append([
                one.name, one.points[-1].row.test, str(len(one.labels)), number(chart.centre, 5),
                f"{number(low, 5)} .. {number(high, 5)}", one.unit, number(chart.process, 3), str(len(one.signals)),
            ])  # fmt: skip
        parts: list[Block] = [Table(HEADS, rows, f"{self.quantity} over all units; limits of the last", (2, 3, 6, 7))]
        words = {"beyond": "outside its limits", "run": f"{RUN} or more in a row on one side", "spread": "spread"}
        lines = [f"{one.name}, {label}: {words[kind]}" for one in self.groups for label, kind in one.signals]
        parts += lines[:12] + ([f"... {len(lines) - 12} more signals"] if lines[12:] else [])
        return (*parts, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a point of a chart."""
        from ..core.show.frames import frame  # noqa: PLC0415 - starts slowly

        every = [(one, i) for one in self.groups for i in range(len(one.labels))]
        columns: dict[str, object] = {
            "figure": [one.name for one, _ in every], "test": [one.points[-1].row.test for one, _ in every],
            "label": [one.labels[i] for one, i in every], "value": [float(one.chart.values[i]) for one, i in every],
            "lower": [float(one.chart.lower[i]) for one, i in every],
            "upper": [float(one.chart.upper[i]) for one, i in every], "unit": [one.unit for one, _ in every],
        }  # fmt: skip
        return frame(columns)


def trend(
    connection: Connection,
    quantity: str,
    axis: str | None = None,
    test: str | None = None,
    part: str | None = None,
    by: By = "unit",
    every: bool = False,
) -> Trend:
    """Return the trend of a quantity.

    Parameters
    ----------
    connection : Connection
        That reads.
    quantity : str
        Which.
    axis, test, part : str, optional
        Of these alone.
    by : {"unit", "lot"}
        A point a unit, or one a lot.
    every : bool
        All tests of a unit, not the last alone.

    Raises
    ------
    DataError
        ``no_figure``; ``few_figures`` where no chart has enough.
    """
    conditions = [results.c.quantity == quantity]
    conditions += [results.c.axis == axis] if axis else []
    conditions += [results.c.test == test] if test else []
    conditions += [items.c.part == part] if part else []
    found = points(connection, *conditions, last=not every)
    timed = [one for one in found if one.time_ns is not None]
    if not timed:
        what = f"no figure of {quantity} with an uncertainty and a day is in the archive"
        raise DataError(what, do="See: inertialcal archive list", code="no_figure")
    groups, few = [], 0
    for each in _groups(timed):
        unit = each[-1].row.unit
        figures = in_unit(each, unit)
        try:
            if by == "lot":
                known = [(figure, one) for figure, one in zip(figures, each, strict=True) if one.lot]
                names = [one.lot for _, one in known]
                chart = lots([figure for figure, _ in known], names)
                labels = [name for name in dict.fromkeys(names) if names.count(name) > 1]
            else:
                chart, labels = individuals(figures), [one.serial for one in each]
        except DataError:
            few += 1
            continue
        groups.append(Group(by, tuple(each), chart, tuple(labels), unit))
    if not groups:
        what = f"{quantity}: too few {'lots' if by == 'lot' else 'units'} for a chart"
        do = "State lot in [item] of the campaigns" if by == "lot" else "Three units are the least: add campaigns"
        raise DataError(what, do=do, code="few_figures")
    return Trend(quantity, tuple(groups), tuple(_remarks(groups, few, len(found) - len(timed))))


def _groups(found: Sequence[Point]) -> list[list[Point]]:
    """Return figures by what they are of, those of one dimension."""
    groups: dict[Hashable, list[Point]] = {}
    kind_of = itemgetter(*(found[0].found._fields.index(name) for name in KIND))
    for point in found:
        kind = kind_of(point.found)
        place = str(At(*kind[:3])) if kind[0] else ""  # as tables show it
        groups.setdefault((place, kind[3:]), []).append(point)
    for kind, group in groups.items():
        unit = group[-1].found.unit
        groups[kind] = [one for one in group if one.found.unit == unit or same_dimension(one.found.unit, unit)]
    return list(groups.values())


def _remarks(groups: Sequence[Group], few: int, untimed: int) -> list[Remark]:
    remarks = []
    short = [one for one in groups if len(one.labels) < FEW]
    if short:
        what = f"fewer than {FEW} points: the limits are themselves uncertain"
        remarks.append(Remark("few_points", "info", what, count=len(short)))
    if few:
        remarks.append(Remark("few_figures", "info", "figures of too few units or lots for a chart", count=few))
    if untimed:
        what = "figures of tests whose day is not known: they stand in no chart"
        remarks.append(Remark("no_time", "warning", what, count=untimed, do='State day = "2026-11-29" in [[tests]]'))
    return remarks
