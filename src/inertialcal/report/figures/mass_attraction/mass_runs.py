"""Scale factor of each run with a moved mass, of all runs, and in the published way.

Whiskers are 95 % intervals from the noise of each run alone. A null run is drawn at its response over
the amplitude of a moved mass: zero is expected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
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
SHOWS = "Scale factor of each run with its 95 % interval; hollow: mass at rest; band: all runs"
ROOM, GAP = 280.0, 10.0  # for the names of all runs, and between two of them [pt]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    found = []
    for one in curves(results, NAME):
        if len(finite(numbers(one, "scale_factor"))):
            row, test, axis = _row(results, one), str(one.get("test", "")), str(one.get("axis", ""))
            found.append(Picture(NAME, test, axis, finding(one, row), SHOWS, (2.3,), partial(draw, one, row)))
    return found


def _row(results: Mapping[str, Any], curve: Curve) -> Mapping[str, Any] | None:
    """Return the row of the scale factor of all runs; None without one."""
    key = ("scale_factor", curve.get("test", ""), curve.get("axis", ""))
    rows = [
        row
        for row in results.get("results", [])
        if (row["quantity"], row["test"], row["axis"]) == key and row["value"] is not None
        and not case_of(row).beside
    ]  # fmt: skip
    return rows[0] if rows else None


def finding(curve: Curve, row: Mapping[str, Any] | None) -> str:
    """Return the finding: the scale factor of all runs."""
    moved = int(flags(curve, "moved").sum())
    if row is None:
        return f"{moved} run{'s' * (moved != 1)}: scale factor cannot be told from noise"
    said = f"{with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}"
    return f"{moved} run{'s' * (moved != 1)} with the mass moved: {said}"


def draw(curve: Curve, row: Mapping[str, Any] | None, axes: Sequence[Axes], title: str) -> None:
    """Draw the runs of a test."""
    (ax,) = axes
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
    less = numbers(curve, "published_fourier") - numbers(curve, "published_fourier_noise")
    with np.errstate(invalid="ignore", divide="ignore"):
        published = less * value / numbers(curve, "response")
    if np.isfinite(published).any():
        ax.plot(at + 0.18, published, linestyle="none", marker="x", markersize=5.0, color=COLOURS["vermilion"],
                label="noise subtracted, as published", zorder=4)  # fmt: skip
    room = ROOM / max(len(value), 1) - GAP
    ax.set_xticks(at)
    ax.set_xticklabels([shortened(plain(name), TEXT, room) for name in words(curve, "run")], parse_math=False)
    ax.set_xlim(-0.6, len(value) - 0.4)
    set_title(ax, title)
    set_labels(ax, "run", with_unit("scale factor", unit(curve, "scale_factor")))
    set_legend(ax)
