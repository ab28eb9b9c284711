"""Density of all axes together over time and frequency."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit
from .clock import scaled

NAME = "microgravity_spectrogram"
SHOWS = "Density over time and frequency: the darker, the higher"
HEIGHT = 2.6  # of the panel [in]
SHADES = (0.08, 0.2, 0.36, 0.56, 0.78, 1.0)
MOST_DECADES = 5.0


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [_picture(one) for one in curves(results, NAME)]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(
        NAME, str(curve.get("test", "")), str(curve.get("axis", "")), finding(curve), SHOWS, (HEIGHT,), paint
    )


def finding(curve: Curve) -> str:
    """Return the finding: at which frequency the density is highest over the whole record."""
    _, frequency, density = grid(curve)
    mean = np.nanmean(density, axis=0)
    at = number(float(frequency[int(np.nanargmax(mean))]), 3)
    return f"Highest density at {at} Hz; shades in {plain(unit(curve, 'density'))}"


def grid(curve: Curve) -> tuple[Array, Array, Array]:
    """Return times, frequencies and densities, shape (t, f)."""
    time, frequency, density = (numbers(curve, name) for name in ("time", "frequency", "density"))
    many = int(np.count_nonzero(time == time[0]))
    return time[::many], frequency[:many], density.reshape(-1, many)


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw cells: neighbours of one shade as one bar, so that a page stays small."""
    time, frequency, density = grid(curve)
    clock, word = scaled(time)
    wide = float(clock[1] - clock[0]) if len(clock) > 1 else 1.0
    high = float(frequency[1] - frequency[0]) if len(frequency) > 1 else 1.0
    with np.errstate(divide="ignore"):
        level = np.log10(density)
    shown = level[np.isfinite(level)]
    low, top = (float(one) for one in np.percentile(shown, (2.0, 99.8))) if len(shown) else (0.0, 1.0)
    low = max(low, top - MOST_DECADES)
    ends = np.linspace(low, top, len(SHADES) + 1)
    shade = np.digitize(np.where(np.isfinite(level), level, -math.inf), ends[1:-1])
    for k, dark in enumerate(SHADES):
        bars = _bars((shade == k) & np.isfinite(level))
        name = f"{_level(ends[k])} to {_level(ends[k + 1])}"
        corners = [
            ((clock[i] + side * wide, frequency[j] + (end - 0.5) * high), code)
            for i, j, n in bars
            for side, end, code in ((-0.5, 0, Path.MOVETO), (0.5, 0, Path.LINETO), (0.5, n, Path.LINETO),
                                    (-0.5, n, Path.LINETO), (-0.5, 0, Path.CLOSEPOLY))
        ]  # fmt: skip
        if corners:  # one path a shade: a page stays small
            shape = Path([place for place, _ in corners], [code for _, code in corners])
            ax.add_patch(PathPatch(shape, facecolor=COLOURS["blue"], alpha=dark, linewidth=0.0, label=name))
    ax.set_xlim(float(clock[0]) - 0.5 * wide, float(clock[-1]) + 0.5 * wide)
    ax.set_ylim(0.0, float(frequency[-1]) + 0.5 * high)
    set_title(ax, title)
    set_labels(ax, with_unit("time", word), with_unit("frequency", "Hz"))
    set_legend(ax)


def _level(power: float) -> str:
    """Return ten to a power as few digits."""
    return f"{float(f'{10.0**power:.2g}'):g}"


def _bars(inside: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> list[tuple[int, int, int]]:
    """Return column, first row and height of each upright run of cells."""
    found = []
    for i, column in enumerate(inside):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], column, [False]]).astype(int)))
        found += [(i, int(a), int(b - a)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return found


__all__ = ["NAME", "draw", "finding", "grid", "pictures"]
