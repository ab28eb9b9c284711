"""Bias over temperature: the cells of all runs with the polynomial, and below it what the polynomial leaves.

Above, the reading as it is, so that run-to-run offsets show as scatter. Below, the offset of each run is taken off:
what is left is the gap between the paths, drawn with what was found for it, and noise. Filled where it warmed, hollow
where it cooled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ....core.show.rounding import number, with_uncertainty
from ..drawing.data import Curve, curves, distinct, finite, numbers, thinned, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "thermal"
SHOWS = (
    "Above, mean reading of each bin over temperature with the polynomial; below, what it leaves after the offset of"
    " each run; filled where it warmed, hollow where it cooled"
)
MOST = 600  # cells drawn
PATHS: dict[str, dict[str, Any]] = {
    "warming": {"marker": "o", "color": COLOURS["vermilion"], "markersize": 3.2},
    "cooling": {
        "marker": "o", "markerfacecolor": "none", "markeredgecolor": COLOURS["blue"], "markersize": 3.6,
    },
}  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and sensor."""
    laws = {(one.get("test"), one.get("axis")): one for one in curves(results, "thermal_law")}
    found = []
    for cells in curves(results, "thermal_cells"):
        law = laws.get((cells.get("test"), cells.get("axis")))
        if law is not None and len(finite(numbers(cells, "reading"))):
            found.append(_picture(cells, law, _gap(results, cells)))
    return found


def _gap(results: Mapping[str, Any], cells: Curve) -> Mapping[str, Any] | None:
    """Return the row of the mean difference of the paths."""
    key = ("path_difference", cells.get("test"), cells.get("axis"))
    rows = [row for row in results.get("results", []) if (row["quantity"], row["test"], row["axis"]) == key]
    return rows[0] if rows else None


def _picture(cells: Curve, law: Curve, gap: Mapping[str, Any] | None) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, cells, law, title)

    test, axis = str(cells.get("test", "")), str(cells.get("axis", ""))
    return Picture(NAME, test, axis, finding(cells, law, gap), SHOWS, (2.1, 1.6), paint)


def finding(cells: Curve, law: Curve, gap: Mapping[str, Any] | None) -> str:
    """Return the finding: how well the bias is known over the range, and what the paths differ by."""
    T = numbers(law, "temperature")
    width = finite(0.5 * (numbers(law, "hi") - numbers(law, "lo")))
    span = f"{number(float(T.min()), 3)} to {number(float(T.max()), 3)} {plain(unit(law, 'temperature'))}"
    runs = len(distinct(words(cells, "run")))
    said = f"{plain(cells.get('axis', ''))}: {span}, {runs} run{'s' * (runs != 1)}"
    if len(width):
        said += f", bias within ±{number(float(width.max()), 2)} {plain(unit(law, 'bias'))}"
    if gap is not None and gap["value"] is not None and gap["u"] is not None:
        said += f"; warming minus cooling {with_uncertainty(gap['value'], gap['u'])} {plain(gap['unit'])}"
    return said


def draw(axes: Sequence[Axes], cells: Curve, law: Curve, title: str = "") -> None:
    """Draw readings on the first axes and what is left of them on the second."""
    above, below = axes
    T, lo, hi = (numbers(law, name) for name in ("temperature", "lo", "hi"))
    if np.isfinite(lo).any():
        above.fill_between(T, lo, hi, color=COLOURS["sky"], alpha=0.45, linewidth=0.0, label="95 %, at each", zorder=1)
    _points(above, cells, "reading")
    above.plot(T, numbers(law, "bias"), color=COLOURS["ink"], linewidth=1.2, label="polynomial", zorder=5)
    below.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    _points(below, cells, "residual")
    _paths(below, law)
    set_title(above, title)
    set_labels(above, y=with_unit("bias", unit(law, "bias")))
    set_labels(
        below, with_unit("temperature", unit(law, "temperature")), with_unit("left over", unit(cells, "residual"))
    )
    seen = dict(zip(*reversed(above.get_legend_handles_labels()), strict=True))
    seen |= dict(zip(*reversed(below.get_legend_handles_labels()), strict=True))
    set_legend(below, list(seen.values()))


def _points(ax: Axes, cells: Curve, column: str) -> None:
    T, y = numbers(cells, "temperature"), numbers(cells, column)
    path = np.array(words(cells, "path"))
    for way, look in PATHS.items():
        mine: NDArray[np.intp] = np.flatnonzero((path == way) & np.isfinite(y))
        shown = mine[thinned(y[mine], MOST // 2)]
        if len(shown):
            ax.plot(T[shown], y[shown], linestyle="none", label=f"{way} ({len(mine)} cells)", zorder=3, **look)


def _paths(ax: Axes, law: Curve) -> None:
    """Draw half the difference of the paths above and below, with its 95 % interval."""
    if "path_difference" not in law["columns"]:
        return
    T, gap, lo, hi = (numbers(law, name) for name in ("temperature", "path_difference", "path_lo", "path_hi"))
    for sign, colour in ((0.5, "vermilion"), (-0.5, "blue")):
        ax.plot(T, sign * gap, color=COLOURS[colour], linewidth=1.2, zorder=5)
        if np.isfinite(lo).any():
            ax.fill_between(T, sign * lo, sign * hi, color=COLOURS[colour], alpha=0.2, linewidth=0.0, zorder=2)
