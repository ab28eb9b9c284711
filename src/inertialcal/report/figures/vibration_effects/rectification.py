"""Rectification: mean readings of segments, even drift taken off, against the mean square of the vibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.constants import STANDARD_GRAVITY
from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "rectification"
SHOWS = (
    "Mean reading of segments without even drift, with 95 % intervals, over the mean square of the control; the line"
)
HEIGHT = 2.6  # of the panel [in]
LOOKS = (("o", "blue"), ("s", "vermilion"), ("^", "green"), ("D", "purple"))  # of runs


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture an axis and direction."""
    found = []
    for curve in curves(results, "vibration_effect_means"):
        if len(finite(numbers(curve, "mean"))) > 1:
            test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
            found.append(_picture(curve, _row(results, test, axis), test, axis))
    return found


def _row(results: Mapping[str, Any], test: str, axis: str) -> Mapping[str, Any] | None:
    rows = (one for one in results.get("results", []) if one["quantity"] == "vibration_rectification"
            and one["test"] == test and one["axis"] == axis and one["method"] == "result")  # fmt: skip
    return next(rows, None)


def _picture(curve: Curve, row: Mapping[str, Any] | None, test: str, axis: str) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    return Picture(NAME, test, axis, finding(row, axis), SHOWS, (HEIGHT,), paint)


def finding(row: Mapping[str, Any] | None, axis: str) -> str:
    """Return the finding: the rectification, or why there is none."""
    if row is None or row["value"] is None or row["status"] == "not_estimated":
        said = "" if row is None or row["reason"] is None else f": {row['reason']['text']}"
        return f"{plain(axis)}: no rectification{plain(said, 60)}"
    return f"{plain(axis)}: rectification {with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}"


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw the means of segments, run by run, and the line of least squares through them.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``vibration_effect_means``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    square = numbers(curve, "mean_square") / STANDARD_GRAVITY.value**2
    mean, u, run = (numbers(curve, name) for name in ("without_drift", "u", "run"))
    several = len(np.unique(run)) > 1
    for k, each in enumerate(np.unique(run)):
        of = run == each
        marker, colour = LOOKS[k % len(LOOKS)]
        label = f"run {each:.0f}" if several else "means of segments"
        ax.errorbar(square[of], mean[of], 2.0 * u[of], linestyle="none", marker=marker, color=COLOURS[colour],
                    markersize=4.0, linewidth=1.0, label=label)  # fmt: skip
    if np.all(u > 0.0):
        weight = 1.0 / u**2
        slope = float(np.sum(weight * square * mean) / np.sum(weight * square**2))
        ends = np.array([0.0, float(np.max(square))])
        ax.plot(ends, slope * ends, color=COLOURS["ink"], linewidth=1.0, label="line", zorder=1)
    set_title(ax, title)
    set_labels(ax, with_unit("mean square of the control", "g^2"), with_unit("mean reading", unit(curve, "mean")))
    set_legend(ax)
