"""Bias against a condition: levels of each power-up with all other terms taken off, the fit and its 95 % band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import with_uncertainty
from ....core.show.rows import Quoted
from ....core.show.wording import words as wording
from ..drawing.data import Curve, curves, distinct, numbers, unit, words
from ..drawing.metrics import shortened
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title, with_unit
from .panels import HEIGHT, places, plot_power_ups

NAME, LEVELS = "sensitivity", "sensitivity_levels"
SHOWS = "Bias against a condition: levels of each power-up, other terms taken off, with the fit and its 95 % band"
LONGEST = 150.0  # width of the name of a condition: one line with its unit [pt]
Pair = tuple[Curve, Curve]  # law and levels of a sensor


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and condition, which is the axis that it is asked for by; with a panel a sensor."""
    levels = {(one["test"], one["axis"], one.get("of", "")): one for one in curves(results, LEVELS)}
    found: dict[tuple[str, str], list[Pair]] = {}
    for law in curves(results, NAME):
        points = levels.get((law["test"], law["axis"], law.get("of", "")))
        if points is not None:
            found.setdefault((law["test"], str(law.get("of", ""))), []).append((law, points))
    return [_picture(test, name, pairs, results.get("results", [])) for (test, name), pairs in found.items()]


def _picture(test: str, name: str, pairs: Sequence[Pair], rows: Sequence[Mapping[str, Any]]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, name, pairs, title)

    data = tuple(one for pair in pairs for one in pair)
    return Picture(
        NAME, test, name, finding(test, name, pairs, rows), SHOWS, (HEIGHT,) * len(pairs), paint, data=data,
        note=(Quoted(wording(name)),),
    )  # fmt: skip


def finding(test: str, name: str, pairs: Sequence[Pair], rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: the first term of the condition of each sensor, or that it was not seen."""
    axes = [law["axis"] for law, _ in pairs]
    own: dict[str, Mapping[str, Any]] = {}
    for row in rows:
        if row["test"] == test and row["quantity"] == f"bias_{name}" and row["axis"] in axes:
            own.setdefault(row["axis"], row)
    said = [f"{plain(axis, 12)} {_figure(row)}" for axis, row in own.items() if row["value"] is not None]
    if not said:
        return f"{', '.join(plain(axis, 12) for axis in axes)}: bias against {plain(wording(name))}"
    return f"Bias by {plain(wording(name))}: {', '.join(said)} {plain(next(iter(own.values()))['unit'])}"


def _figure(row: Mapping[str, Any]) -> str:
    if row["status"] == "upper_limit":
        return f"below {row['value']:.2g}"
    return with_uncertainty(row["value"], row["u"])


def draw(axes: Sequence[Axes], name: str, pairs: Sequence[Pair], title: str = "") -> None:
    """Draw levels and fit of each sensor on a panel of its own."""
    runs = distinct(run for _, points in pairs for run in words(points, "run"))
    for ax, (law, points) in zip(axes, pairs, strict=True):
        at, bias, lo, hi = (numbers(law, column) for column in ("condition", "bias", "lo", "hi"))
        ax.fill_between(at, lo, hi, color=COLOURS["blue"], alpha=0.2, linewidth=0.0, zorder=1)
        ax.plot(at, bias, color=COLOURS["blue"], linewidth=1.2, label="fit, 95 % band", zorder=2)
        x, y = numbers(points, "condition"), numbers(points, "reading")
        at_runs = zip(runs, places(words(points, "run"), runs), strict=True)
        plot_power_ups(ax, {run: np.stack([x[mine], y[mine]]) for run, mine in at_runs}, "levels of a power-up")
        set_labels(ax, y=with_unit(f"{plain(law['axis'], 12)} bias", unit(law, "bias")))
    set_title(axes[0], title)
    shown = shortened(plain(wording(name)), TEXT, LONGEST)
    set_labels(axes[-1], with_unit(shown, unit(pairs[0][0], "condition")))
    set_legend(axes[-1])
