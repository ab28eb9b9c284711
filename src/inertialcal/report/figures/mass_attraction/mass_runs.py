"""Scale factor of each run with a moved mass, what they give together, and what the published way makes of each.

Whiskers are 95 % intervals from the noise beside the line of each run alone. A null run stands at the response that it
has, over what would have been applied: zero is expected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.results import case_of
from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, curves, finite, flags, numbers, unit, words
from ..drawing.metrics import shortened
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title, with_unit

NAME = "mass_runs"
SHOWS = "Scale factor of each run with its 95 % interval; hollow: the mass was not moved; the band is that of all runs"
ROOM, GAP = 280.0, 10.0  # for the names of all runs, and between two of them [pt]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [
        _picture(one, _row(results, one))
        for one in curves(results, NAME)
        if len(finite(numbers(one, "scale_factor")))
    ]  # fmt: skip


def _row(results: Mapping[str, Any], curve: Curve) -> Mapping[str, Any] | None:
    """Return the row of the scale factor of all runs; None where there is none."""
    key = ("scale_factor", curve.get("test", ""), curve.get("axis", ""))
    rows = [
        row
        for row in results.get("results", [])
        if (row["quantity"], row["test"], row["axis"]) == key and row["value"] is not None
        and not case_of(row).beside
    ]  # fmt: skip
    return rows[0] if rows else None


def _picture(curve: Curve, row: Mapping[str, Any] | None) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, row, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve, row), SHOWS, (2.3,), paint)


def finding(curve: Curve, row: Mapping[str, Any] | None) -> str:
    """Return the finding: the scale factor of all runs."""
    moved = int(flags(curve, "moved").sum())
    if row is None:
        return f"{moved} run{'s' * (moved != 1)}: no scale factor is told from noise"
    said = f"{with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}"
    return f"{moved} run{'s' * (moved != 1)} with the mass moved: {said}"


def draw(ax: Axes, curve: Curve, row: Mapping[str, Any] | None, title: str = "") -> None:
    """Draw the runs of a test.

    Parameters
    ----------
    ax : Axes
        Where.
    curve : mapping
        ``mass_runs`` of ``results.json``.
    row : mapping or None
        Of the scale factor of all runs.
    title : str
        Above it; empty for none.
    """
    value, lo, hi = (numbers(curve, name) for name in ("scale_factor", "lo", "hi"))
    moved, at = flags(curve, "moved"), np.arange(len(value))
    interval = None if row is None else row["interval"]
    if row is not None:
        if interval is not None:
            ax.axhspan(interval["lo"], interval["hi"], color=COLOURS["sky"], alpha=0.45, linewidth=0.0,
                       label="all runs, 95 %")  # fmt: skip
        ax.axhline(row["value"], color=COLOURS["ink"], linewidth=1.2, label="all runs")
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    ax.vlines(at, lo, hi, color=COLOURS["blue"], linewidth=1.3, zorder=3)
    for mask, face, label in ((moved, COLOURS["blue"], "mass moved"), (~moved, "none", "mass at rest")):
        if np.isfinite(value[mask]).any():
            ax.plot(at[mask], value[mask], linestyle="none", marker="o", markersize=5.0, markerfacecolor=face,
                    markeredgecolor=COLOURS["blue"], label=label, zorder=4)  # fmt: skip
    _published(ax, curve, at)
    room = ROOM / max(len(value), 1) - GAP
    ax.set_xticks(at)
    ax.set_xticklabels([shortened(plain(name), TEXT, room) for name in words(curve, "run")], parse_math=False)
    ax.set_xlim(-0.6, len(value) - 0.4)
    set_title(ax, title)
    set_labels(ax, "run", with_unit("scale factor", unit(curve, "scale_factor")))
    set_legend(ax)


def _published(ax: Axes, curve: Curve, at: Any) -> None:
    """Draw what the published way makes of each run: the line less the mean amplitude beside it."""
    value, response = numbers(curve, "scale_factor"), numbers(curve, "response")
    less = numbers(curve, "published_fourier") - numbers(curve, "published_fourier_noise")
    with np.errstate(invalid="ignore", divide="ignore"):
        shown = less * value / response
    if np.isfinite(shown).any():
        ax.plot(at + 0.18, shown, linestyle="none", marker="x", markersize=5.0, color=COLOURS["vermilion"],
                label="noise subtracted, as published", zorder=4)  # fmt: skip
