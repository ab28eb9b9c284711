"""Spectral density over frequency: each record with its interval, the same terms as in the Allan deviation, lines.

The density is that of bands. A line is marked at its own frequency, over the highest band around it; a broad peak once,
over its highest band.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ....core.results import case_of
from ....core.show.rounding import number
from ....core.show.wording import listed
from ..drawing.data import Curve, curves, finite, flags, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit
from .noise_terms import draw_terms, mark

NAME = "spectrum"
SHOWS = "One-sided density over frequency, both logarithmic; shaded is the 95 % interval, lines are the fitted terms"
HEIGHT = 2.6  # of the panel [in]
ROOM = 1.6
NAMED = 3  # lines in a finding
OVER = 1.25  # factor by which a mark stands over its peak
LINE: dict[str, Any] = {"marker": "v", "markersize": 5.0, "color": COLOURS["vermilion"]}
BROAD: dict[str, Any] = LINE | {"markerfacecolor": "none"}
STROKES = ("-", (0, (4, 1)), (0, (1, 1)), (0, (4, 1, 1, 1)))  # of records


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and axis."""
    known = [one for one in curves(results, NAME) if np.any(numbers(one, "density") > 0.0)]
    found = []
    for test, axis in dict.fromkeys((str(one.get("test", "")), str(one.get("axis", ""))) for one in known):
        mine = [one for one in known if (one.get("test", ""), one.get("axis", "")) == (test, axis)]
        found.append(_picture(results, test, axis, mine))
    return found


def _picture(results: Mapping[str, Any], test: str, axis: str, mine: Sequence[Curve]) -> Picture:
    lines = list(_lines(results, test, axis).values())

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], mine, title, lines)

    return Picture(NAME, test, axis, finding(results, test, axis, mine), SHOWS, (HEIGHT,), paint)


def finding(results: Mapping[str, Any], test: str, axis: str, mine: Sequence[Curve]) -> str:
    """Return the finding: lines that stand out of the noise, by their frequency; the range without any."""
    named = list(_lines(results, test, axis))
    if not named:
        every = np.concatenate([finite(numbers(one, "frequency")) for one in mine])
        return (
            f"{plain(axis)}: no line found from {number(float(every.min()), 2)} to {number(float(every.max()), 3)} Hz"
        )
    first, rest = named[:NAMED], len(named) - NAMED
    at = f"{', '.join(first)} Hz and {rest} more" if rest > 0 else f"{listed(first)} Hz"
    return f"{plain(axis)}: {'lines' if len(named) > 1 else 'line'} at {at}"


def _lines(results: Mapping[str, Any], test: str, axis: str) -> dict[str, float]:
    """Return the frequency of each line of an axis by its name, of several records that of the first [Hz]."""
    found: dict[str, float] = {}
    for row in results.get("results", []):
        if (row["test"], row["axis"], row["quantity"]) == (test, axis, "line_frequency") and row["value"] is not None:
            found.setdefault(plain(case_of(row).number), float(row["value"]))
    return found


def draw(ax: Axes, mine: Sequence[Curve], title: str = "", lines: Sequence[float] = ()) -> None:
    """Draw the spectra of all records of an axis, and the terms."""
    for place, curve in enumerate(mine):
        frequency, density = numbers(curve, "frequency"), numbers(curve, "density")
        lo, hi = numbers(curve, "lo"), numbers(curve, "hi")
        band = np.isfinite(lo) & np.isfinite(hi) & (lo > 0.0)
        if band.any():
            ax.fill_between(frequency, lo, hi, where=band.tolist(), color=COLOURS["sky"], alpha=0.35, linewidth=0.0,
                            zorder=1, label="95 % interval" if place == 0 else None)  # fmt: skip
        name = plain(curve.get("recording", "")) if len(mine) > 1 else "measured"
        ax.plot(frequency, np.where(density > 0.0, density, np.nan), color=COLOURS["blue"], linewidth=0.9, zorder=2,
                linestyle=STROKES[place % len(STROKES)], label=name)  # fmt: skip
    draw_terms(ax, numbers(mine[0], "frequency"), mine[0])
    _mark(ax, [(one, max(_height(curve, one) for curve in mine)) for one in lines], "line", LINE)
    _mark(ax, [peak for curve in mine for peak in _broad(curve, lines)], "broad peak", BROAD)
    shown = np.concatenate([finite(numbers(one, name)) for one in mine for name in ("density", "lo", "hi")])
    mark(ax, mine[0], "corner", "corner of the low pass")
    log_axis(ax, "x", np.concatenate([numbers(one, "frequency") for one in mine]), 1.15)
    log_axis(ax, "y", shown, ROOM)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", unit(mine[0], "frequency")), with_unit("density", unit(mine[0], "density")))
    set_legend(ax)


def _mark(ax: Axes, peaks: Sequence[tuple[float, float]], name: str, look: Mapping[str, Any]) -> None:
    if peaks:
        x, y = (np.array(values) for values in zip(*peaks, strict=True))
        ax.plot(x, OVER * y, linestyle="none", zorder=5, label=name, **look)


def _height(curve: Curve, frequency: float) -> float:
    """Return the largest density of the bands around a frequency."""
    density = numbers(curve, "density")
    at = _band(curve, frequency)
    return float(np.nanmax(density[max(at - 1, 0) : at + 2], initial=0.0))


def _band(curve: Curve, frequency: float) -> int:
    return int(np.nanargmin(np.abs(np.log(numbers(curve, "frequency") / frequency))))


def _broad(curve: Curve, lines: Sequence[float]) -> list[tuple[float, float]]:
    """Return the highest band of each peak that holds no line, as frequency and density."""
    known = {_band(curve, one) for one in lines}
    at = np.flatnonzero(flags(curve, "line"))
    peaks = [part for part in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if len(part)]
    return [_highest(curve, part) for part in peaks if not known & set(range(int(part[0]) - 1, int(part[-1]) + 2))]


def _highest(curve: Curve, bands: NDArray[np.intp]) -> tuple[float, float]:
    density = np.nan_to_num(numbers(curve, "density"))
    at = bands[int(np.argmax(density[bands]))]
    return float(numbers(curve, "frequency")[at]), float(density[at])


__all__ = ["NAME", "draw", "finding", "pictures"]
