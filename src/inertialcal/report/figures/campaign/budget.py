"""Uncertainty budget as bars: the share of the variance from each source, one bar per quantity.

Type A (observed scatter) is plain, type B (certificates and other knowledge) hatched; the same source has the same
colour in every bar.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from ....core.show.rows import quantity_name
from ....core.show.wording import counted
from ..drawing.data import distinct
from ..drawing.metrics import folded, shortened
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title

NAME = "budget"
SHOWS = "One bar per quantity, divided into the share of the variance from each source"
ROLES = ("blue", "orange", "green", "vermilion", "sky", "purple", "yellow")
ROW = 0.3  # height of a bar with its gap [in]
LEAST = 0.6  # height of the panel [in]
WIDEST = 120.0  # of the name of a quantity [pt]
ROOM = 180.0  # beside it, for the name of a source [pt]
MOST = 12  # bars: what fits beside its text on a page

Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Source:
    """One entry of the legend: a source of one type with its colour."""

    name: str
    kind: str
    role: str

    @property
    def label(self) -> str:
        """Name and type."""
        return folded(f"{self.name} ({self.kind})", TEXT - 1.0, ROOM)


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    every = results.get("budgets", [])
    tests = distinct(row["test"] for row in every if row.get("share") is not None)
    return [of_rows([row for row in every if row["test"] == test], test) for test in tests]


def of_rows(every: Rows, test: str) -> Picture:
    """Return the picture of the budgets of one test; what has no share is not drawn."""
    rows = [row for row in every if row.get("share") is not None]

    shown = _quantities(rows)[:MOST]
    drawn = [row for row in rows if _of(row) in shown]

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], drawn, title)

    rest = len(_quantities(rows)) - len(shown)
    note = (f" {counted(rest, 'quantity').capitalize()} more: see the tables.",) if rest else ()
    return Picture(NAME, test, "", finding(rows), SHOWS, (LEAST + ROW * len(shown),), paint, data=every, note=note)


def finding(rows: Rows) -> str:
    """Return the finding: which source is most often the largest."""
    largest = [max((r for r in rows if _of(r) == what), key=lambda row: row["share"]) for what in _quantities(rows)]
    names = [row["source"] for row in largest]
    first = max(distinct(names), key=names.count)
    return f"{plain(first)} is the largest source in {names.count(first)} of {len(names)} quantities"


def draw(ax: Axes, rows: Rows, title: str = "") -> None:
    """Draw the budgets of one test."""
    quantities, known = _quantities(rows), sources(rows)
    for place, quantity in enumerate(quantities):
        left = 0.0
        for source in known:
            share = 100.0 * sum(r["share"] for r in rows if _of(r) == quantity and _source(r, known) is source)
            if share > 0.0:
                ax.barh(place, share, left=left, height=0.66, **_look(source))
                left += share
    ax.set_yticks(range(len(quantities)), labels=[_label(quantity) for quantity in quantities], parse_math=False)
    ax.set_ylim(len(quantities) - 0.4, -0.6)
    ax.set_xlim(0.0, 100.0)
    ax.tick_params(axis="y", length=0)
    set_title(ax, title)
    set_labels(ax, "share of the variance [%]")
    set_legend(ax, [Patch(label=source.label, **_look(source)) for source in known])


def sources(rows: Rows) -> list[Source]:
    """Return the sources, the largest first; from the eighth on they share one entry, which counts them."""
    totals: dict[tuple[str, str], float] = {}
    for row in rows:
        key = (row["source"], row["kind"])
        totals[key] = totals.get(key, 0.0) + row["share"]
    order = sorted(totals, key=lambda key: -totals[key])
    own = order if len(order) <= len(ROLES) else order[: len(ROLES)]
    found = [Source(plain(name), kind, ROLES[i]) for i, (name, kind) in enumerate(own)]
    rest = len(order) - len(own)
    return [*found, Source(f"{rest} smaller sources", "A, B", "quiet")] if rest else found


def _source(row: Mapping[str, Any], known: Sequence[Source]) -> Source:
    name, kind = plain(row["source"]), row["kind"]
    return next((one for one in known if (one.name, one.kind) == (name, kind)), known[-1])


def _of(row: Mapping[str, Any]) -> tuple[str, str, str]:
    return quantity_name(row), row["axis"], row["sensor"]


def _quantities(rows: Rows) -> list[tuple[str, str, str]]:
    return list(dict.fromkeys(_of(row) for row in rows))


def _label(quantity: tuple[str, str, str]) -> str:
    name, axis, sensor = quantity
    short = {"accelerometer": "acc"}.get(sensor, sensor)
    return shortened(plain(" ".join(filter(None, (short, name.replace("_", " "), axis))), 36), TEXT - 1.0, WIDEST)


def _look(source: Source) -> dict[str, Any]:
    hatch = "////" if "B" in source.kind else ""
    return {"facecolor": COLOURS[source.role], "edgecolor": COLOURS["paper"], "hatch": hatch, "linewidth": 0.6}
