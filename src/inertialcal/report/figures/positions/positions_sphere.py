"""Positions on the sphere of directions: where up was, seen from the body, and how well each position agrees.

The whole sphere in Hammer's equal-area projection [1]_: the z axis of the body at the top, its x axis in the middle,
its y axis a quarter to the right. Size and colour of a mark are its residual; a cross is where the largest gap is, in
the middle of what no position has seen.

References
----------
.. [1] J. P. Snyder, USGS Professional Paper 1395, 1987, p. 182 (Aitoff and Hammer).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, flags, numbers
from ..drawing.metrics import Box, placed
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title
from .positions_residuals import in_ug

NAME = "positions_sphere"
SHOWS = (
    "The sphere of directions as an equal-area map in body axes, z at the top, x in the middle, y a quarter to the"
    " right: where up was in each position; larger marks have larger residuals; a cross is in the largest gap"
)
ACROSS, HIGH = 2.0 * np.sqrt(2.0), np.sqrt(2.0)  # half axes of the map
SMALLEST, LARGEST, LEFT_OUT = 12.0, 110.0, 45.0  # areas of marks [pt^2]
GRID = 12_000  # directions tried for the largest gap
POLES = {"+x": (1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0), "+z": (0, 0, 1), "-z": (0, 0, -1)}
POINTS = 56.0  # in a unit of the map, about
MARGIN = 1.13  # of half the map, so that marks and names at its edge are whole
NUMBERED = 60  # positions, above which no number could be read
APART = 0.16  # on the map: marks that are nearer have one number


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    found = []
    for curve in curves(results, "positions"):
        if len(finite(numbers(curve, "up_x"))):
            found.append(_picture(curve))
    return found


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(NAME, str(curve.get("test", "")), "", finding(curve), SHOWS, (2.35,), paint)


def finding(curve: Curve) -> str:
    """Return the finding: how many positions, and how far the farthest direction is from any of them."""
    up = directions(curve)
    gap = largest_gap(up)[1]
    left = int(np.sum(flags(curve, "left_out")))
    out = f", {left} left out" if left else ""
    return f"{len(up)} positions{out}; no direction is farther than {number(gap, 2)} deg from one of them"


def directions(curve: Curve) -> Array:
    """Return unit vectors of up, shape (m, 3), of the positions that have one."""
    up = np.column_stack([numbers(curve, f"up_{axis}") for axis in "xyz"])
    up = up[np.isfinite(up).all(axis=1)]
    return np.asarray(up / np.linalg.norm(up, axis=1)[:, None])


def largest_gap(up: Array) -> tuple[Array, float]:
    """Return the direction that is farthest from all positions, and how far [deg]."""
    i = np.arange(GRID) + 0.5
    z, turn = 1.0 - 2.0 * i / GRID, np.pi * (1.0 + np.sqrt(5.0)) * i
    across = np.sqrt(1.0 - z**2)
    tried = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    nearest = np.max(np.clip(tried @ up.T, -1.0, 1.0), axis=1)
    at = int(np.argmin(nearest))
    return tried[at], float(np.degrees(np.arccos(nearest[at])))


def on_map(up: Array) -> tuple[Array, Array]:
    """Return the places of directions on the map, each shape (m,)."""
    along = np.arctan2(up[:, 1], up[:, 0])
    high = np.arcsin(np.clip(up[:, 2], -1.0, 1.0))
    shrink = np.sqrt(2.0 / (1.0 + np.cos(high) * np.cos(along / 2.0)))
    return 2.0 * shrink * np.cos(high) * np.sin(along / 2.0), shrink * np.sin(high)


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw the map.

    Parameters
    ----------
    ax : Axes
        One.
    curve : mapping
        ``positions`` of ``results.json``.
    title : str
        Above; empty for none.
    """
    _globe(ax)
    up = np.column_stack([numbers(curve, f"up_{axis}") for axis in "xyz"])
    seen = np.isfinite(up).all(axis=1)
    x, y = on_map(up)
    sizes = _sizes(curve)
    left = flags(curve, "left_out") & seen
    residual = _signed(curve)
    groups = (
        ("reads too much", seen & ~left & (residual >= 0.0), {"color": COLOURS["vermilion"], "marker": "o"}),
        ("reads too little", seen & ~left & (residual < 0.0), {"color": COLOURS["blue"], "marker": "s"}),
        ("left out", left, {"facecolor": "none", "edgecolor": COLOURS["ink"], "marker": "D"}),
    )
    for label, mask, look in groups:
        if mask.any():
            ax.scatter(x[mask], y[mask], s=sizes[mask], alpha=0.85, label=label, zorder=4, **look)  # type: ignore[arg-type]
    radius = 0.5 * np.sqrt(sizes)
    taken = [Box(POINTS * a, POINTS * b, r, r) for a, b, r in zip(x[seen], y[seen], radius[seen], strict=True)]
    far = largest_gap(directions(curve))[0]
    fx, fy = on_map(far[None, :])
    ax.plot(fx, fy, "x", color=COLOURS["ink"], markersize=7, markeredgewidth=1.4, linestyle="none",
            label="farthest from all", zorder=5)  # fmt: skip
    taken.append(Box(POINTS * float(fx[0]), POINTS * float(fy[0]), 4.0, 4.0))
    taken += _name_axes(ax, taken)
    if np.sum(seen) <= NUMBERED:
        _number(ax, x, y, radius, seen, taken)
    set_title(ax, title)
    set_labels(ax, "up in body axes; marks grow with the residual")
    set_legend(ax, below=-22.0)


def _sizes(curve: Curve) -> Array:
    size = np.where(flags(curve, "left_out"), 0.0, np.nan_to_num(np.abs(_signed(curve))))
    largest = float(size.max(initial=0.0))
    share = size / largest if largest > 0.0 else size
    areas = SMALLEST + (LARGEST - SMALLEST) * share
    return np.asarray(np.where(flags(curve, "left_out"), LEFT_OUT, areas))


def _signed(curve: Curve) -> Array:
    """Return the residual along gravity of each position, shape (m,)."""
    return in_ug(curve, "residual")


def _globe(ax: Axes) -> None:
    """Draw the outline, meridians and parallels every 30 deg, and the axes of the body."""
    ax.add_patch(Ellipse((0, 0), 2 * ACROSS, 2 * HIGH, facecolor="none", edgecolor=COLOURS["quiet"], linewidth=0.8))
    for turn in np.radians(np.arange(-150.0, 180.0, 30.0)):
        high = np.linspace(-np.pi / 2, np.pi / 2, 61)
        ring = np.column_stack([np.cos(high) * np.cos(turn), np.cos(high) * np.sin(turn), np.sin(high)])
        ax.plot(*on_map(ring), color=COLOURS["grid"], linewidth=0.6, zorder=1)
    for tilt in np.radians(np.arange(-60.0, 90.0, 30.0)):
        turn = np.linspace(-np.pi + 1e-6, np.pi - 1e-6, 121)
        ring = np.column_stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.full(121, np.sin(tilt))])
        ax.plot(*on_map(ring), color=COLOURS["grid"], linewidth=0.6, zorder=1)
    ax.set_xlim(-MARGIN * ACROSS, MARGIN * ACROSS)
    ax.set_ylim(-1.14 * HIGH, 1.16 * HIGH)
    ax.set_xticks([])
    ax.set_yticks([])
    for side in ax.spines.values():
        side.set_visible(False)


def _name_axes(ax: Axes, marks: Sequence[Box]) -> list[Box]:
    """Write the names of the body's axes where they cover no mark; return where they stand."""
    found: list[Box] = []
    for name, vector in POLES.items():
        x, y = (float(one[0]) for one in on_map(np.array([vector], dtype=np.float64)))
        ax.plot(x, y, "+", color=COLOURS["quiet"], markersize=6, zorder=2)
        found.append(_word(ax, name, (x, y), 3.0, TEXT - 1.0, COLOURS["quiet"], [*marks, *found]))
    for side in (-1.0, 1.0):  # -x is the edge of the map, on both sides
        at = Box(side * (POINTS * ACROSS + 13.0), 0.0, 7.0, 4.5)
        _write(ax, "-x", (side * ACROSS, 0.0), at, TEXT - 1.0, COLOURS["quiet"])
        found.append(at)
    return found


def _number(ax: Axes, x: Array, y: Array, radius: Array, seen: Any, taken: Sequence[Box]) -> None:
    """Write the numbers of positions beside their marks; of those that lie on one another that of the first."""
    told: list[tuple[float, float]] = []
    boxes = list(taken)
    for k in np.flatnonzero(seen):
        if any(np.hypot(x[k] - a, y[k] - b) < APART for a, b in told):
            continue
        told.append((float(x[k]), float(y[k])))
        place = (float(x[k]), float(y[k]))
        boxes.append(_word(ax, f"{k + 1}", place, float(radius[k]), TEXT - 3.0, COLOURS["ink"], boxes))


def _word(
    ax: Axes, text: str, place: tuple[float, float], radius: float, size: float, colour: str, taken: Sequence[Box]
) -> Box:
    """Write a word beside a mark; return where it stands."""
    box = placed(POINTS * place[0], POINTS * place[1], radius, text, size, taken)
    _write(ax, text, place, box, size, colour)
    return box


def _write(ax: Axes, text: str, place: tuple[float, float], box: Box, size: float, colour: str) -> None:
    away = (box.x - POINTS * place[0], box.y - POINTS * place[1])
    ax.annotate(plain(text).replace("-", "\N{MINUS SIGN}"), place, away, textcoords="offset points", color=colour,
                size=size, ha="center", va="center", zorder=6, parse_math=False)  # fmt: skip
