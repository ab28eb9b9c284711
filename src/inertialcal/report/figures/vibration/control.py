"""Density of the control at full level: its profile, the tolerance around it, the band that holds for all lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "vibration"
SHOWS = (
    "Above, density over frequency, both logarithmic, with the profile; below, its deviation from the profile in"
    " decibels; shaded is the interval that holds for all lines together"
)
HEIGHTS = (2.4, 1.8)  # of the panels [in]
ROOM = 1.6


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    return [_picture(results, one) for one in curves(results, "vibration_control")]


def _picture(results: Mapping[str, Any], curve: Curve) -> Picture:
    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    limits = _limits(results, test)

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, limits, title)

    return Picture(NAME, test, axis, finding(results, curve), SHOWS, HEIGHTS, paint)


def _limits(results: Mapping[str, Any], test: str) -> list[tuple[float | None, float | None]]:
    """Return the tolerances that the lines of a test were judged by [dB]."""
    return [
        (one["lower"], one["upper"])
        for one in results.get("verdicts", [])
        if one["test"] == test and one["unit"] == "dB"
    ]


def finding(results: Mapping[str, Any], curve: Curve) -> str:
    """Return the finding: the verdict where one was asked for, and how far the lines are from the profile."""
    test = str(curve.get("test", ""))
    away = finite(numbers(curve, "deviation"))
    span = f"lines {number(float(away.min()), 2)} to {number(float(away.max()), 2)} dB from the profile"
    verdict = next((one["verdict"] for one in results.get("verdicts", [])
                    if one["test"] == test and one["unit"] == "dB"), "")  # fmt: skip
    return f"{verdict}: {span}" if verdict else f"Control: {span}"


def draw(
    axes: Sequence[Axes], curve: Curve, limits: Sequence[tuple[float | None, float | None]] = (), title: str = ""
) -> None:
    """Draw density and deviation.

    Parameters
    ----------
    axes : sequence of Axes, length 2
        Over frequency.
    curve : mapping
        ``vibration_control``.
    limits : sequence of (float, float)
        Lowest and highest deviation allowed [dB].
    title : str
        Above the first; empty for none.
    """
    above, below = axes
    frequency, profile = numbers(curve, "frequency"), numbers(curve, "profile")
    density, lo, hi = (numbers(curve, name) for name in ("density", "lo", "hi"))
    above.fill_between(frequency, lo, hi, color=COLOURS["sky"], alpha=0.45, linewidth=0.0, zorder=1,
                       label="95 %, all lines together")  # fmt: skip
    above.plot(frequency, density, color=COLOURS["blue"], linewidth=0.8, zorder=3, label="control")
    above.plot(frequency, profile, color=COLOURS["ink"], linewidth=1.3, zorder=4, label="profile")
    deviation = numbers(curve, "deviation")
    below.fill_between(frequency, _in_decibels(lo / profile), _in_decibels(hi / profile), color=COLOURS["sky"],
                       alpha=0.45, linewidth=0.0, zorder=1)  # fmt: skip
    below.plot(frequency, deviation, color=COLOURS["blue"], linewidth=0.8, zorder=3)
    below.axhline(0.0, color=COLOURS["ink"], linewidth=1.3, zorder=2)
    shown, ends = [density, lo, hi, profile], [deviation]
    for place, pair in enumerate(limits):
        for end in (one for one in pair if one is not None):
            label = "tolerance" if place == 0 and end == next(one for one in pair if one is not None) else None
            look: dict[str, Any] = {"color": COLOURS["vermilion"], "linewidth": 1.1, "linestyle": (0, (5, 2))}
            above.plot(frequency, profile * 10.0 ** (0.1 * end), zorder=4, label=label, **look)
            below.axhline(end, zorder=4, **look)
            shown.append(profile * 10.0 ** (0.1 * end))
            ends.append(np.array([1.15 * end]))
    log_axis(above, "x", frequency, 1.05)
    log_axis(below, "x", frequency, 1.05)
    log_axis(above, "y", np.concatenate([finite(one) for one in shown]), ROOM)
    size = 1.1 * float(np.max(np.abs(np.concatenate([finite(one) for one in ends]))))
    below.set_ylim(-size, size)
    set_title(above, title)
    set_labels(above, "", with_unit("density", unit(curve, "density")))
    set_labels(below, with_unit("frequency", unit(curve, "frequency")), "deviation [dB]")
    set_legend(below, above.get_legend_handles_labels()[0])


def _in_decibels(ratio: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(10.0 * np.log10(ratio))


__all__ = ["NAME", "draw", "finding", "pictures"]
