"""Bias against a condition: levels of each power-up with all other terms taken off, the fit and its 95 % band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, curves, distinct, numbers, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME, LEVELS = "sensitivity", "sensitivity_levels"
SHOWS = "Bias against a condition: levels of each power-up, other terms taken off, with the fit and its 95 % band"
HEIGHT = 2.2  # of a panel [in]
MARKS = "osD^v<>ph*"
NAMED = 6  # power-ups that a legend names


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a sensor and condition."""
    levels = {(one["test"], one["axis"], one.get("of", "")): one for one in curves(results, LEVELS)}
    found = []
    for law in curves(results, NAME):
        points = levels.get((law["test"], law["axis"], law.get("of", "")))
        if points is not None:
            found.append(_picture(law, points, results.get("results", [])))
    return found


def _picture(law: Curve, points: Curve, rows: Sequence[Mapping[str, Any]]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, law, points, title)

    return Picture(NAME, law["test"], law["axis"], finding(law, rows), SHOWS, (HEIGHT,), paint, data=(law, points))


def finding(law: Curve, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: the first term of the condition, or that it was not seen."""
    name = str(law.get("of", ""))
    axis = plain(law["axis"], 12)
    own = [row for row in rows if row["test"] == law["test"] and row["axis"] == law["axis"]
           and row["quantity"] == f"bias_{name}" and row["value"] is not None]  # fmt: skip
    if not own:
        return f"{axis}: bias against {plain(name)}"
    row = own[0]
    if row["status"] == "upper_limit":
        return f"{axis}: no effect of {plain(name)} seen; below {row['value']:.2g} {plain(row['unit'])}"
    return f"{axis}: {with_uncertainty(row['value'], row['u'])} {plain(row['unit'])} with {plain(name)}"


def draw(axes: Sequence[Axes], law: Curve, points: Curve, title: str = "") -> None:
    """Draw levels and fit."""
    (ax,) = axes
    at, bias, lo, hi = (numbers(law, name) for name in ("condition", "bias", "lo", "hi"))
    ax.fill_between(at, lo, hi, color=COLOURS["blue"], alpha=0.2, linewidth=0.0, zorder=1)
    ax.plot(at, bias, color=COLOURS["blue"], linewidth=1.2, label="fit, 95 % band", zorder=2)
    condition, reading, runs = numbers(points, "condition"), numbers(points, "reading"), words(points, "run")
    every = distinct(runs)
    for i, run in enumerate(every):
        mine = np.array([one == run for one in runs])
        label = plain(run, 16) if len(every) <= NAMED else ("levels of a power-up" if i == 0 else None)
        ax.plot(condition[mine], reading[mine], MARKS[i % len(MARKS)], color=COLOURS["vermilion"], markersize=3.5,
                markerfacecolor="none", label=label, zorder=3)  # fmt: skip
    set_title(ax, title)
    set_labels(ax, with_unit(plain(law.get("of", "condition")), unit(law, "condition")),
               with_unit(f"{plain(law['axis'], 12)} bias", unit(law, "bias")))  # fmt: skip
    set_legend(ax)
